// What the technique of a sample is: a row of numbers at the start of the texture of the tables.
const TECHNIQUE_TEXELS: u32 = 16u;

fn technique_numbers(texel: u32) -> vec4f {
    return table_entry(technique() * TECHNIQUE_TEXELS + texel);
}
