//! Pictures in a texture of the caller's, on a device of the caller's.

use strahl_gpu::{Device, Renderer, TextureTarget, wgpu};
use strahl_scene::{Scene, resolve};
use strahl_volume::{Control, Phantom};

/// An adapter, a device and its queue, opened without this crate.
fn opened() -> Option<(wgpu::Adapter, wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let Some(adapter) = adapters.into_iter().next() else {
        println!("skipped: there is no graphics adapter");
        return None;
    };
    let description = wgpu::DeviceDescriptor {
        required_features: adapter.features() & Device::USEFUL_FEATURES,
        required_limits: adapter.limits(),
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&description)).unwrap();
    Some((adapter, device, queue))
}

/// The numbers of a texture of four 32-bit floats per texel.
fn read(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Vec<[f32; 4]> {
    let size = texture.size();
    // Rows begin at multiples of 256 bytes.
    let bytes_per_row = (16 * size.width).next_multiple_of(256);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(bytes_per_row * size.height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(bytes_per_row),
        rows_per_image: None,
    };
    let to = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout,
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let mapped = buffer.slice(..).get_mapped_range().unwrap();
    let mut numbers = vec![0.0f32; mapped.len() / 4];
    bytemuck::cast_slice_mut(&mut numbers).copy_from_slice(&mapped);
    numbers
        .chunks_exact(bytes_per_row as usize / 4)
        .flat_map(|row| row[..4 * size.width as usize].chunks_exact(4))
        .map(|pixel| [pixel[0], pixel[1], pixel[2], pixel[3]])
        .collect()
}

#[test]
fn a_texture_gets_what_a_picture_in_memory_holds() {
    let Some((adapter, device, queue)) = opened() else {
        return;
    };
    let volume = Phantom::Tree.volume([32; 3]).unwrap();
    let ours = Device::from_parts(&adapter, device.clone(), queue.clone());
    let mut renderer = Renderer::new(&ours, &volume);
    for (what, text, most) in [
        ("one part", r#""size": [90, 70]"#, 0.0),
        // Parts are 512 pixels wide.
        ("two parts", r#""size": [530, 20]"#, 0.0),
        (
            "frames",
            r#""size": [60, 40], "frames": 5, "jitter": { "seed": 3 }"#,
            1e-6,
        ),
        (
            "display space",
            r#""size": [60, 40], "compositing": "display""#,
            2e-5,
        ),
    ] {
        let scene = Scene::parse("scene", &format!("{{ {text} }}")).unwrap();
        let plan = resolve(&scene, &volume.header(), None).unwrap();
        let expected = renderer.render(&plan, &Control::NONE).unwrap().image;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: plan.width,
                height: plan.height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        let target = TextureTarget {
            view: &view,
            format: texture.format(),
        };
        renderer
            .render_into(&plan, &target, &Control::NONE)
            .unwrap();
        let found = read(&device, &queue, &texture);
        assert_eq!(found.len(), expected.pixels().len());
        assert!(found.iter().any(|pixel| pixel[1] > 0.1), "{what}");
        for (i, (found, expected)) in found.iter().zip(expected.pixels()).enumerate() {
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() <= most, "{what}, pixel {i}: {a} for {b}");
            }
        }
    }
}
