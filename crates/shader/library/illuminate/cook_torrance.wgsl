//! Rough mirror facets (R. Cook and K. Torrance 1982) with the distribution of B. Walter et al.
//! (2007) and the height-correlated masking of E. Heitz (2014), whose denominator is never 0 where
//! the surface is lit: no NaN.
struct Params {
    /// Share of the color that follows the angle to the light.
    /// default 0.8, range 0 to 10
    diffuse: f32,
    /// How rough the facets are.
    /// default 0.4, range 0.05 to 1
    roughness: f32,
    /// How much light is mirrored head on.
    /// default 0.04, range 0 to 1
    reflectance: f32,
}

fn illuminate(color: vec3f, normal: vec3f, to_eye: vec3f, light: Light) -> vec3f {
    let to_light = dot(normal, light.direction);
    if !(to_light > 0.0) {
        return vec3f(0.0);
    }
    let eye = max(dot(normal, to_eye), 1e-4);
    let between = light.direction + to_eye;
    let half = between / max(length(between), 1e-4);
    let a = params.roughness * params.roughness;
    let a2 = a * a;
    let cosine_of_half = clamp(dot(normal, half), 0.0, 1.0);
    let spread = cosine_of_half * cosine_of_half * (a2 - 1.0) + 1.0;
    // Without 1/pi throughout, so that the diffuse part is as bright as Lambert's.
    let facets = a2 / (spread * spread);
    let masking = 0.5 / (to_light * sqrt(eye * eye * (1.0 - a2) + a2) + eye * sqrt(to_light * to_light * (1.0 - a2) + a2));
    let fresnel = params.reflectance
        + (1.0 - params.reflectance) * pow(1.0 - clamp(dot(light.direction, half), 0.0, 1.0), 5.0);
    return light.radiance * to_light * (params.diffuse * color + facets * masking * fresnel);
}
