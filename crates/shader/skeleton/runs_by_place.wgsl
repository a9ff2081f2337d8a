// What a sample adds to the importance of its run.
fn importance_of_place(position: vec3f) -> f32 {
    return table_entry(4u).x * importance_at(position);
}
