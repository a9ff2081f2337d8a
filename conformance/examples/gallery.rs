//! Draws the gallery: one small picture per variant into `docs/gallery`, and the page that shows them with
//! how alike both renderers draw. `cargo xtask gallery` calls it.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use strahl_conformance::agreement::agreement;
use strahl_conformance::gallery::{gallery, scene};
use strahl_conformance::golden::Golden;
use strahl_gpu::Device;
use strahl_scene::{Scene, resolve};
use strahl_volume::Control;
use strahl_volume::phantom::Phantom;

const SIZE: [u32; 2] = [128, 128];
const DIMS: [usize; 3] = [72, 90, 114];

const HEAD: &str = "# Gallery

One picture per variant of every step of the ray. Each scene draws the phantom `anatomy` with 72 × 90 × 114 voxels and sets as few keys as
possible. `cargo xtask gallery` draws all pictures again, on the CPU and on the graphics adapter. *Alike* is the peak signal-to-noise
ratio between both in dB. *Off* is the number of pixels in which a channel differs by more than 8/255, and the number of those
outside silhouettes.

";

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .ok_or("no root")?;
    let folder = root.join("docs/gallery");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let volume = Phantom::Anatomy.volume(DIMS)?;
    let device = Device::open(None);
    let mut page = HEAD.to_owned();
    match &device {
        Ok(device) => writeln!(page, "Graphics adapter: {}.\n", device.adapter())?,
        Err(error) => return Err(format!("the gallery compares with an adapter: {error}").into()),
    }
    let device = device?;
    let mut gpu = strahl_gpu::Renderer::new(&device, &volume);
    writeln!(page, "| | step | variant | scene | alike | off |")?;
    writeln!(page, "|---|---|---|---|---|---|")?;
    let mut differ = Vec::new();
    for variant in &gallery() {
        let (step, name, keys) = variant;
        let text = scene(variant, SIZE);
        let plan = resolve(&Scene::parse(name, &text)?, &volume.header(), None)?;
        let cpu = strahl_cpu::Renderer::new(&volume).render(
            &plan,
            &Default::default(),
            &Control::NONE,
        )?;
        let with = gpu.render(&plan, &Control::NONE)?;
        let alike = agreement(&cpu.image, &with.image);
        let pixels = f64::from(SIZE[0] * SIZE[1]);
        let far = (alike.far * pixels).round();
        let outside = alike.far_outside_silhouettes;
        if alike.psnr_db < 45.0 || outside > 0 {
            differ.push(format!("{name}: {:.1} dB, {outside} pixels", alike.psnr_db));
        }
        Golden::of(&cpu.image).write(&folder.join(format!("{name}.png")))?;
        writeln!(
            page,
            "| ![{name}](gallery/{name}.png) | {step} | {name} | `{keys}` | {:.1} dB | {far}, {outside} |",
            alike.psnr_db,
        )?;
        println!(
            "{name}: {:.1} dB, {far} off, {outside} outside silhouettes",
            alike.psnr_db
        );
    }
    fs::write(root.join("docs/gallery.md"), page)?;
    if differ.is_empty() {
        return Ok(());
    }
    Err(format!("the renderers differ:\n{}", differ.join("\n")).into())
}
