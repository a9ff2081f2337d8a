//! Adapters and the device that draws.

use crate::error::Error;
use crate::signal::Signal;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use strahl_volume::Store;

/// A graphics adapter of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// Its name.
    pub name: String,
    /// The interface that it is reached through, such as `vulkan`.
    pub backend: String,
    /// The driver.
    pub driver: String,
    /// Whether it is a software renderer, which runs on the CPU.
    pub is_software: bool,
}

impl fmt::Display for Adapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}", self.name, self.backend)?;
        if !self.driver.is_empty() {
            write!(f, ", {}", self.driver)?;
        }
        f.write_str(if self.is_software { ", software)" } else { ")" })
    }
}

impl Adapter {
    fn of(adapter: &wgpu::Adapter) -> Adapter {
        let info = adapter.get_info();
        Adapter {
            name: info.name,
            backend: info.backend.to_string(),
            driver: info.driver_info,
            is_software: info.device_type == wgpu::DeviceType::Cpu,
        }
    }
}

/// All adapters that can draw, hardware first.
pub fn adapters() -> Vec<Adapter> {
    let found = pollster::block_on(found());
    let usable = found.iter().filter(|adapter| can_draw(adapter));
    usable.map(Adapter::of).collect()
}

/// Whether an adapter draws into the textures that pictures are made in. Some drivers for OpenGL do not.
fn can_draw(adapter: &wgpu::Adapter) -> bool {
    let features = adapter.get_texture_format_features(wgpu::TextureFormat::Rgba32Float);
    let usages = features.allowed_usages;
    usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT)
}

async fn found() -> Vec<wgpu::Adapter> {
    let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
    description.backends = wgpu::Backends::PRIMARY | wgpu::Backends::SECONDARY;
    let instance = wgpu::Instance::new(description);
    let mut found = instance.enumerate_adapters(wgpu::Backends::all()).await;
    found.sort_by_key(|adapter| {
        let info = adapter.get_info();
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
            wgpu::DeviceType::Cpu => 3,
        };
        let is_gl = info.backend == wgpu::Backend::Gl;
        (!can_draw(adapter), kind, is_gl)
    });
    found
}

/// An open adapter. Clones are the same device.
#[derive(Clone, Debug)]
pub struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    adapter: Arc<Adapter>,
    trouble: Arc<Mutex<Option<Trouble>>>,
    store: Arc<Store>,
}

/// What is kept on a device: 2 GiB.
const USUAL_BUDGET_BYTES: usize = 2 << 30;

#[derive(Clone, Debug)]
enum Trouble {
    Lost(String),
    Refused(String),
}

impl Device {
    /// Opens the best adapter, or the best one that has `name` in its name (in any case).
    ///
    /// # Errors
    /// There is none, or it cannot be used.
    pub fn open(name: Option<&str>) -> Result<Device, Error> {
        pollster::block_on(Device::open_async(name))
    }

    /// As [`Device::open`], where nothing may block: in a web page.
    ///
    /// # Errors
    /// As [`Device::open`].
    pub async fn open_async(name: Option<&str>) -> Result<Device, Error> {
        let all = found().await;
        if all.is_empty() {
            return Err(Error::NoAdapter);
        }
        let wanted = name.unwrap_or_default().to_lowercase();
        let chosen = all
            .iter()
            .find(|a| a.get_info().name.to_lowercase().contains(&wanted))
            .ok_or_else(|| Error::NoSuchAdapter {
                name: name.unwrap_or_default().to_owned(),
                known: all
                    .iter()
                    .map(|a| Adapter::of(a).to_string())
                    .collect::<Vec<_>>()
                    .join("; "),
            })?;
        if !can_draw(chosen) {
            return Err(Error::Device {
                adapter: Adapter::of(chosen).to_string(),
                why: "it cannot draw into textures of 32-bit floats; install a Vulkan driver"
                    .to_owned(),
            });
        }
        let description = wgpu::DeviceDescriptor {
            label: Some("strahl"),
            required_features: chosen.features() & Device::USEFUL_FEATURES,
            // The presets allow far smaller volumes than drivers do.
            required_limits: chosen.limits(),
            ..Default::default()
        };
        let opened = chosen.request_device(&description).await;
        let (device, queue) = opened.map_err(|why| Error::Device {
            adapter: Adapter::of(chosen).to_string(),
            why: why.to_string(),
        })?;
        Ok(Device::from_parts(chosen, device, queue))
    }

    /// What is used where an adapter has it: filtering of 16- and 32-bit numbers, blending of slices.
    pub const USEFUL_FEATURES: wgpu::Features = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM
        .union(wgpu::Features::FLOAT32_FILTERABLE)
        .union(wgpu::Features::FLOAT32_BLENDABLE);

    /// A device that somebody else opened on `adapter`, and draws with as well: that of a window, say. Ask for
    /// [`USEFUL_FEATURES`](Device::USEFUL_FEATURES) as far as the adapter has them, and for its limits. From now on
    /// the device tells its losses and errors here.
    pub fn from_parts(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Device {
        let trouble = Arc::new(Mutex::new(None));
        let seen = trouble.clone();
        device.set_device_lost_callback(move |reason, message| {
            // Dropping the device is no loss.
            if reason != wgpu::DeviceLostReason::Destroyed {
                *seen.lock().unwrap_or_else(PoisonError::into_inner) = Some(Trouble::Lost(message));
            }
        });
        let seen = trouble.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            seen.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .get_or_insert(Trouble::Refused(error.to_string()));
        }));
        Device {
            device,
            queue,
            adapter: Arc::new(Adapter::of(adapter)),
            trouble,
            store: Arc::new(Store::with_budget(USUAL_BUDGET_BYTES)),
        }
    }

    /// Gives the device another budget for what is kept on it: volumes, coefficients, meshes. Whatever is there is
    /// given up.
    pub fn with_budget(self, budget_bytes: usize) -> Device {
        Device {
            store: Arc::new(Store::with_budget(budget_bytes)),
            ..self
        }
    }

    /// What is kept on the device; sizes are those there.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// The adapter.
    pub fn adapter(&self) -> &Adapter {
        &self.adapter
    }

    /// Whether it blends what it draws into 32-bit floats.
    pub(crate) fn can_blend(&self) -> bool {
        let features = self.device.features();
        features.contains(wgpu::Features::FLOAT32_BLENDABLE)
    }

    /// What went wrong since the last call, if anything.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let mut trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner);
        match &*trouble {
            None => Ok(()),
            Some(Trouble::Lost(why)) => Err(Error::Lost(why.clone())),
            Some(Trouble::Refused(why)) => {
                let why = why.clone();
                *trouble = None;
                Err(Error::Driver(why))
            }
        }
    }

    /// Waits until everything that was handed in is done. A web page does other things meanwhile; elsewhere this
    /// thread waits, and whatever callbacks wait for has happened then.
    pub(crate) async fn done(&self) -> Result<(), Error> {
        let signal = Signal::default();
        let of_queue = signal.clone();
        self.queue
            .on_submitted_work_done(move || of_queue.give(Ok(())));
        if cfg!(not(target_arch = "wasm32")) {
            let done = self.device.poll(wgpu::PollType::wait_indefinitely());
            self.check()?;
            return done
                .map(|_| ())
                .map_err(|why| Error::Driver(why.to_string()));
        }
        signal.await.map_err(Error::Driver)?;
        self.check()
    }
}
