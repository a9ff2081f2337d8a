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

/// Renderers by the adapter that was asked for.
struct Open {
    renderers: BTreeMap<Option<String>, Renderer>,
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
                renderers: BTreeMap::new(),
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
        open.renderers.remove(&None);
    }

    /// How many were opened so far.
    pub fn opened(&self) -> u64 {
        self.open
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .opened
    }

    /// What `draw` makes with the renderer on `adapter`, drawing from `data`. A device may be lost at any time: the driver
    /// was updated or reset. It is opened again once.
    pub fn draw<T>(
        &self,
        adapter: Option<&str>,
        data: &Datasets,
        control: &Control,
        draw: impl Fn(&mut Renderer) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let mut open = locked(&self.open, control)?;
        let asked = adapter.map(str::to_owned);
        match draw(open.renderer(&asked, data)?) {
            Err(Error::Gpu(strahl_gpu::Error::Lost(_))) if open.can_open_again(&asked) => {
                open.renderers.remove(&asked);
                draw(open.renderer(&asked, data)?)
            }
            done => done,
        }
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
    fn renderer(
        &mut self,
        asked: &Option<String>,
        data: &Datasets,
    ) -> Result<&mut Renderer, Error> {
        if !self.renderers.contains_key(asked) {
            let device = match (&self.given, asked) {
                (Some(given), None) => given.clone(),
                _ => {
                    self.opened += 1;
                    Device::open(asked.as_deref())?
                }
            };
            let renderer = Renderer::with_store(&device, Datasets::default(), self.store.clone());
            self.renderers.insert(asked.clone(), renderer);
        }
        match self.renderers.get_mut(asked) {
            Some(renderer) => {
                renderer.set_data(data);
                Ok(renderer)
            }
            None => unreachable!("it has just been put there"),
        }
    }

    fn can_open_again(&self, asked: &Option<String>) -> bool {
        asked.is_some() || self.given.is_none()
    }
}
