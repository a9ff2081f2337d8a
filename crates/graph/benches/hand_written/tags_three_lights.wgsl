// A table of colors for each tag of a second volume, three lights one on top of the other, tone shading,
// boundaries and silhouettes.

@group(0) @binding(32) var luts: texture_2d<f32>;

fn with_light(below: vec3f, surface: vec3f, normal: vec3f, to_eye: vec3f, light: vec3f, radiance: vec3f, specular: f32, shininess: f32) -> vec3f {
    let to_light = direction(light);
    let between = direction(to_light + to_eye);
    let diffuse = max(dot(normal, to_light), 0.0);
    let highlight = select(0.0, pow(max(dot(normal, between), 0.0), shininess), diffuse > 0.0);
    return below + radiance * (surface * diffuse + specular * highlight);
}

fn march(pixel: vec2u) -> vec4f {
    let ray = ray_of(pixel);
    current = 0u;
    let line = line_of(ray);
    let interval = extent_mm(line);
    entry_mm = interval.x;
    let first = line.start + interval.x * line.along;
    let step = line.along * frame.step_mm;
    let count = ceil((interval.y - interval.x) / frame.step_mm - 0.5);
    let to_eye = -ray.direction;
    var color = vec3f(0.0);
    var opacity = 0.0;
    var k = 0.0;
    while k < count {
        let position = first + (k + 0.5) * step;
        k += 1.0;
        current = 0u;
        let value = reconstruct(position);
        let place = place_mm(position);
        current = 1u;
        let tag = floor(4.0 * texel(vec3i(floor(voxel_of(place) + 0.5))) + 0.5);
        current = 0u;

        let size = vec2i(textureDimensions(luts));
        let across = clamp((value + 900.0) / 1800.0, 0.0, 1.0) * f32(size.x - 1);
        let column = i32(across);
        let row = clamp(i32(tag + 0.5), 0, size.y - 1);
        let look = mix(
            textureLoad(luts, vec2i(column, row), 0),
            textureLoad(luts, vec2i(min(column + 1, size.x - 1), row), 0),
            across - f32(column),
        );
        if look.a > 0.0 {
            let values = settings();
            let g = gradient(position);
            let steepest = direction(g);
            let normal = select(steepest, -steepest, dot(steepest, to_eye) < 0.0);
            var lit = with_light(look.rgb * 0.25, look.rgb, normal, to_eye, values.to_light_1, values.radiance, values.specular, values.shininess);
            lit = with_light(lit, look.rgb, normal, to_eye, values.to_light_2, values.radiance, values.specular, values.shininess);
            lit = with_light(lit, look.rgb, normal, to_eye, values.to_light_3, values.radiance, values.specular, values.shininess);

            let warmth = 0.5 * (1.0 + dot(normal, direction(values.to_warm)));
            let toned = mix(mix(values.cool, values.warm, warmth), lit * (0.4 + 0.6 * warmth), values.share);

            let steep = clamp(magnitude(g) / values.boundary.w, 0.0, 1.0);
            var shown = clamp(look.a * (values.boundary.x + values.boundary.y * pow(steep, values.boundary.z)), 0.0, 1.0);
            if dot(normal, normal) > 0.0 {
                let edge = 1.0 - min(abs(dot(normal, to_eye)), 1.0);
                shown = clamp(shown * (values.silhouette.x + values.silhouette.y * pow(edge, values.silhouette.z)), 0.0, 1.0);
            }
            let share = (1.0 - opacity) * opacity_of_step(shown);
            color += share * toned;
            opacity += share;
            if 1.0 - opacity < values.stop_at_transmittance {
                break;
            }
        }
    }
    return vec4f(color, opacity);
}
