//! How much of what is around belongs to the segment of the sample, 0 to 1: normals are those of the border of the
//! segment, whatever the values beside it are. Without segments everything is one, and nothing has a normal.
fn gradient_input(position: vec3f) -> f32 {
    return membership(position);
}
