// The table of value and gradient magnitude, whose rows follow the table of the value alone; `share` is 0 in the first row
// and 1 in the last one. Entries count by their opacity.
fn table_2d(value: f32, share: f32, size: vec2u) -> Surface {
    let domain = table_domain();
    let last = vec2f(size - 1u);
    let column = (value - domain.x) * (last.x / (domain.y - domain.x));
    let place = clamp(vec2f(column, share * last.y), vec2f(0.0), last);
    let index = min(vec2u(place), size - 2u);
    let part = place - vec2f(index);
    var sum = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let corner = vec2u(i & 1u, i >> 1u);
        let sides = select(1.0 - part, part, corner == vec2u(1u));
        let at = index + corner;
        let entry = table_entry(table_first() + (at.y + 1u) * size.x + at.x);
        let weight = sides.x * sides.y * entry.a;
        sum += weight * vec4f(entry.rgb, 1.0);
    }
    if !(sum.a > 0.0) {
        return Surface(vec3f(0.0), 0.0);
    }
    return Surface(sum.rgb / sum.a, sum.a);
}
