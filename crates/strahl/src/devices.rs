//! Graphics devices that are open, and the renderers on them.

use crate::Error;
use crate::locked::locked;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use strahl_gpu::{Device, Renderer, adapters};
use strahl_volume::{Control, Datasets, Store};

/// Every device that a session has opened or was given.
pub struct Devices {
    open: Mutex<Open>,
    /// Part of the name of the best adapter that is no program, if there is one.
    hardware: OnceLock<Option<String>>,
}

/// By the adapter that was asked for.
struct Open {
    devices: BTreeMap<Option<String>, Device>,
    /// Renderers that nobody draws with at the moment.
    idle: Vec<(Option<String>, Renderer)>,
    /// What somebody else opened.
    given: Option<Device>,
    opened: u64,
    store: Arc<Store>,
}

impl Devices {
    /// None yet.
    pub fn new(store: Arc<Store>) -> Devices {
        Devices {
            open: Mutex::new(Open {
                devices: BTreeMap::new(),
                idle: Vec::new(),
                given: None,
                opened: 0,
                store,
            }),
            hardware: OnceLock::new(),
        }
    }

    /// Takes a device that somebody else opened, for whoever names no adapter.
    pub fn give(&mut self, device: Device) {
        let open = self.open.get_mut().unwrap_or_else(PoisonError::into_inner);
        open.given = Some(device);
        open.forget(&None);
    }

    /// How many were opened so far.
    pub fn opened(&self) -> u64 {
        self.open
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .opened
    }

    /// What `draw` makes with a renderer on `adapter` that draws from `data` and that nobody else uses. (It does not wait
    /// for one: a thread of a pool that waits may have to draw a second picture meanwhile.) A device may be lost at any
    /// time: the driver was updated or reset. It is opened again once.
    pub fn draw<T>(
        &self,
        adapter: Option<&str>,
        data: &Datasets,
        control: &Control,
        draw: impl Fn(&mut Renderer) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let asked = adapter.map(str::to_owned);
        match self.draw_once(&asked, data, control, &draw) {
            Err(Error::Gpu(strahl_gpu::Error::Lost(_))) if self.opens_again(&asked, control)? => {
                self.draw_once(&asked, data, control, &draw)
            }
            done => done,
        }
    }

    fn draw_once<T>(
        &self,
        asked: &Option<String>,
        data: &Datasets,
        control: &Control,
        draw: impl Fn(&mut Renderer) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let mut renderer = locked(&self.open, control)?.take(asked)?;
        renderer.set_data(data);
        let done = draw(&mut renderer);
        if !matches!(done, Err(Error::Gpu(strahl_gpu::Error::Lost(_)))) {
            let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
            open.idle.push((asked.clone(), renderer));
        }
        done
    }

    /// Forgets a device that was lost; says whether it may be opened again.
    fn opens_again(&self, asked: &Option<String>, control: &Control) -> Result<bool, Error> {
        let mut open = locked(&self.open, control)?;
        let may = asked.is_some() || open.given.is_none();
        if may {
            open.forget(asked);
        }
        Ok(may)
    }

    /// The best adapter that is no program on the CPU, if there is one: ours is faster.
    pub fn hardware(&self) -> Option<&str> {
        let best = || {
            let found = adapters().into_iter().find(|a| !a.is_software);
            found.map(|adapter| adapter.name)
        };
        self.hardware.get_or_init(best).as_deref()
    }
}

impl Open {
    /// A renderer on the device that was asked for, which is opened if necessary.
    fn take(&mut self, asked: &Option<String>) -> Result<Renderer, Error> {
        if let Some(place) = self.idle.iter().rposition(|(of, _)| of == asked) {
            return Ok(self.idle.swap_remove(place).1);
        }
        let device = match (&self.given, self.devices.get(asked), asked) {
            (Some(given), _, None) => given.clone(),
            (_, Some(device), _) => device.clone(),
            _ => {
                self.opened += 1;
                let device = Device::open(asked.as_deref())?;
                self.devices.insert(asked.clone(), device.clone());
                device
            }
        };
        Ok(Renderer::with_store(
            &device,
            Datasets::default(),
            self.store.clone(),
        ))
    }

    /// Drops a device and the renderers on it.
    fn forget(&mut self, asked: &Option<String>) {
        self.devices.remove(asked);
        self.idle.retain(|(of, _)| of != asked);
    }
}
