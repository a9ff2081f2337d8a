//! Long work: how far it is, and how it ends before it is done.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// What takes long about a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Work {
    /// Data is read, or computed if it is a phantom.
    Reading,
    /// What drawing needs is made of the data.
    Preparing,
    /// The picture is drawn.
    Drawing,
}

/// The work was ended before it was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// What is read needs more memory than its [`Control`] allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("reading takes {bytes} bytes of memory or more; the limit is {most_bytes} bytes")]
pub struct OverBudget {
    /// What it takes, with what has been read before.
    pub bytes: u64,
    /// What it may take.
    pub most_bytes: u64,
}

/// Is told how far work is.
type Listener = dyn Fn(Work, f64) -> ControlFlow<()> + Send + Sync;

/// How whoever asks for long work follows it and ends it: the same for reading, preparing and drawing, in every
/// renderer. Clones are the same control; any of them can be used on any thread.
///
/// ```
/// use strahl_volume::{Control, Phantom};
/// let control = Control::new();
/// control.cancel();
/// let error = Phantom::Tree.volume_under([64; 3], &control).unwrap_err();
/// assert_eq!(error.to_string(), "cancelled");
/// ```
#[derive(Clone, Default)]
pub struct Control {
    state: Option<Arc<State>>,
    memory: Option<Arc<Memory>>,
}

/// How much memory reading may take, and how much it has taken.
struct Memory {
    most_bytes: u64,
    kept_bytes: AtomicU64,
}

struct State {
    is_cancelled: AtomicBool,
    listener: Option<Box<Listener>>,
}

impl Control {
    /// Control of work that goes on to its end, without anybody listening: the same as `default()`.
    pub const NONE: Control = Control {
        state: None,
        memory: None,
    };

    /// Control of work that can be cancelled, without anybody listening.
    pub fn new() -> Control {
        Control::with(None)
    }

    /// Control whose `listener` is told how far a kind of work is, as a share from 0 to 1. `Break` is the same as
    /// [`cancel`](Control::cancel).
    ///
    /// The listener is called on any of the threads that work, so shares may arrive in another order than they were
    /// reached. Each file that is read and each part that is prepared counts from 0 to 1 for itself: one picture may
    /// reach 1 several times. A bar shows the largest share since the kind of work last began anew, at a share below a few
    /// percent.
    pub fn listening(
        listener: impl Fn(Work, f64) -> ControlFlow<()> + Send + Sync + 'static,
    ) -> Control {
        Control::with(Some(Box::new(listener)))
    }

    fn with(listener: Option<Box<Listener>>) -> Control {
        Control {
            state: Some(Arc::new(State {
                is_cancelled: AtomicBool::new(false),
                listener,
            })),
            memory: None,
        }
    }

    /// The same control of reading that takes at most so many bytes of memory, for all files that are read under it.
    /// Beyond, readers give [`OverBudget`]. Clones share what is left.
    #[must_use]
    pub fn with_memory(&self, most_bytes: u64) -> Control {
        Control {
            state: self.state.clone(),
            memory: Some(Arc::new(Memory {
                most_bytes,
                kept_bytes: 0.into(),
            })),
        }
    }

    /// Whether there is room for as many bytes beside those that are kept.
    ///
    /// # Errors
    /// There is not.
    pub(crate) fn has_room(&self, bytes: u64) -> Result<(), OverBudget> {
        let Some(memory) = &self.memory else {
            return Ok(());
        };
        let kept = memory.kept_bytes.load(Ordering::Relaxed);
        memory.check(kept.saturating_add(bytes))
    }

    /// The same of bytes that stay.
    ///
    /// # Errors
    /// There is not.
    pub(crate) fn keep(&self, bytes: u64) -> Result<(), OverBudget> {
        let Some(memory) = &self.memory else {
            return Ok(());
        };
        let kept = memory.kept_bytes.fetch_add(bytes, Ordering::Relaxed);
        memory.check(kept.saturating_add(bytes))
    }

    /// Asks the work to end: it does where it next asks, and says [`Cancelled`]. Does nothing to work under
    /// [`Control::NONE`].
    pub fn cancel(&self) {
        if let Some(state) = &self.state {
            state.is_cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// Whether the work is to end.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        match &self.state {
            Some(state) => state.is_cancelled.load(Ordering::Relaxed),
            None => false,
        }
    }

    /// `Ok` if the work goes on. Long work asks every few milliseconds at the latest.
    ///
    /// # Errors
    /// It was cancelled.
    #[inline]
    pub fn check(&self) -> Result<(), Cancelled> {
        match self.is_cancelled() {
            true => Err(Cancelled),
            false => Ok(()),
        }
    }

    /// Tells whoever listens that `share` of the work is done; then as [`check`](Control::check).
    ///
    /// # Errors
    /// The work was cancelled.
    pub fn report(&self, work: Work, share: f64) -> Result<(), Cancelled> {
        let Some(state) = &self.state else {
            return Ok(());
        };
        self.check()?;
        if let Some(listener) = &state.listener
            && listener(work, share.clamp(0.0, 1.0)).is_break()
        {
            self.cancel();
        }
        self.check()
    }

    /// Counts the parts of work that has `total` of them.
    pub fn parts(&self, work: Work, total: usize) -> Parts<'_> {
        Parts {
            control: self,
            work,
            done: AtomicUsize::new(0),
            total,
        }
    }
}

impl Memory {
    fn check(&self, bytes: u64) -> Result<(), OverBudget> {
        let most_bytes = self.most_bytes;
        match bytes > most_bytes {
            true => Err(OverBudget { bytes, most_bytes }),
            false => Ok(()),
        }
    }
}

impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control")
            .field("is_cancelled", &self.is_cancelled())
            .finish_non_exhaustive()
    }
}

/// The parts of work that are done, counted by all the threads that do them.
#[derive(Debug)]
pub struct Parts<'c> {
    control: &'c Control,
    work: Work,
    done: AtomicUsize,
    total: usize,
}

impl Parts<'_> {
    /// Whether the work is to end.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.control.is_cancelled()
    }

    /// Reports that `number` more parts are done.
    ///
    /// # Errors
    /// The work was cancelled.
    pub fn done(&self, number: usize) -> Result<(), Cancelled> {
        if self.control.state.is_none() {
            return Ok(());
        }
        let done = self.done.fetch_add(number, Ordering::Relaxed) + number;
        let share = done as f64 / self.total.max(1) as f64;
        self.control.report(self.work, share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn clones_cancel_one_another_and_nothing_cancels_none() {
        let control = Control::new();
        let clone = control.clone();
        assert_eq!(control.check(), Ok(()));
        clone.cancel();
        assert_eq!(control.check(), Err(Cancelled));
        assert_eq!(control.report(Work::Drawing, 0.5), Err(Cancelled));
        Control::NONE.cancel();
        assert_eq!(Control::NONE.check(), Ok(()));
    }

    #[test]
    fn clones_share_what_is_left_of_the_memory() {
        let control = Control::new().with_memory(100);
        control.clone().keep(60).unwrap();
        control.has_room(40).unwrap();
        let error = control.has_room(41).unwrap_err().to_string();
        assert!(
            error.contains("101 bytes") && error.contains("100"),
            "{error}"
        );
        control.keep(41).unwrap_err();
        control.cancel();
        assert_eq!(control.clone().check(), Err(Cancelled));
        Control::NONE.keep(u64::MAX).unwrap();
    }

    #[test]
    fn a_listener_hears_of_every_part_and_ends_the_work() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let of_listener = heard.clone();
        let control = Control::listening(move |work, share| {
            of_listener.lock().unwrap().push((work, share));
            match share < 0.5 {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        });
        let parts = control.parts(Work::Reading, 4);
        assert_eq!(parts.done(1), Ok(()));
        assert_eq!(parts.done(1), Err(Cancelled));
        // Who has cancelled is told nothing more.
        assert_eq!(parts.done(1), Err(Cancelled));
        let expected = [(Work::Reading, 0.25), (Work::Reading, 0.5)];
        assert_eq!(*heard.lock().unwrap(), expected);
    }
}
