// The look of the sample that is added: nodes have found it.
var<private> looked_at: Surface;

fn look(sample: Sample) -> Surface {
    return looked_at;
}
