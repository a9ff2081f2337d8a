//! Matt and rough (M. Oren and S. Nayar 1994): V-shaped cavities of facets that each are Lambertian, in the qualitative form
//! of the paper, without interreflection. Flatter than Lambert seen along the light, brighter at the rim.
struct Params {
    /// Share of the color that follows the angle to the light.
    /// default 0.8, range 0 to 10
    diffuse: f32,
    /// Standard deviation of the slope angle of the facets; 0 is Lambert.
    /// default 0.4, range 0 to 1.57, unit rad
    roughness: f32,
}

fn illuminate(color: vec3f, normal: vec3f, to_eye: vec3f, light: Light) -> vec3f {
    let to_light = dot(normal, light.direction);
    if !(to_light > 0.0) {
        return vec3f(0.0);
    }
    let eye = max(dot(normal, to_eye), 0.0);
    let variance = params.roughness * params.roughness;
    let a = 1.0 - 0.5 * variance / (variance + 0.33);
    let b = 0.45 * variance / (variance + 0.09);
    // The cosine between both azimuths times both sines; the larger cosine below it makes sin(alpha) tan(beta).
    let together = max(dot(light.direction, to_eye) - to_light * eye, 0.0);
    let matt = params.diffuse * to_light * (a + b * together / max(to_light, eye));
    return light.radiance * (matt * color);
}
