/// Where each page of `PAGE` voxels an edge lies in its volume's texture, which is an atlas of pages.
/// x: column, row and slice of the page in the atlas, 10 bits each, from the lowest; with bit 31 the
/// page is in no atlas, because all its texels are one number. y: that number, the bits of a float.
@group(0) @binding(12) var pages: texture_3d<u32>;

const PAGE: u32 = 32u;

struct InPages {
    /// Texel of the atlas.
    texel: vec3u,
    is_constant: bool,
    constant: f32,
}

fn in_pages(voxel: vec3i) -> InPages {
    let inside = vec3u(voxel);
    let page = textureLoad(pages, frame.objects[object()].pages_first + inside / PAGE, 0).rg;
    let corner = vec3u(page.r & 1023u, (page.r >> 10u) & 1023u, (page.r >> 20u) & 1023u) * PAGE;
    return InPages(corner + inside % PAGE, (page.r >> 31u) == 1u, bitcast<f32>(page.g));
}
