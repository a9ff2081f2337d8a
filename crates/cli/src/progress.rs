//! Progress on stderr: a bar on a terminal, plain lines elsewhere, nothing for the first half second.

use crate::print;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;
use strahl::{Control, Work};

/// What takes less is not worth a word.
const PATIENCE: Duration = Duration::from_millis(500);
/// Percent between two plain lines.
const PLAIN_STEP: u32 = 20;
/// No part has been told yet; some work has none to tell.
const UNKNOWN: u32 = u32::MAX;

/// The progress of one long piece of work, from its making to its drop. Can be told from many
/// threads.
#[derive(Clone)]
pub struct Progress(Option<Arc<State>>);

struct State {
    what: &'static str,
    percent: AtomicU32,
    shown: Mutex<Shown>,
}

enum Shown {
    NotYet,
    Bar(ProgressBar),
    /// The percentage that was printed last.
    Line(u32),
    Over,
}

impl Progress {
    /// Starts the clock; `what` is a word such as `drawing`.
    pub fn new(what: &'static str, quiet: bool) -> Progress {
        if quiet {
            return Progress(None);
        }
        let state = Arc::new(State {
            what,
            percent: UNKNOWN.into(),
            shown: Mutex::new(Shown::NotYet),
        });
        let later = Arc::downgrade(&state);
        // Without a thread for it, progress is shown by nobody.
        let _ = thread::Builder::new().spawn(move || {
            thread::sleep(PATIENCE);
            if let Some(state) = later.upgrade() {
                state.show();
            }
        });
        Progress(Some(state))
    }

    /// Says that `part` (0 to 1) of the work is done.
    pub fn update(&self, part: f64) {
        let Some(state) = &self.0 else { return };
        let percent = (part.clamp(0.0, 1.0) * 100.0) as u32;
        state.percent.store(percent, Ordering::Relaxed);
        // Another thread is drawing: its number is as good.
        let Ok(mut shown) = state.shown.try_lock() else {
            return;
        };
        match &mut *shown {
            Shown::Bar(bar) => {
                if bar.length().is_none() {
                    bar.set_length(100);
                    bar.set_style(style("{msg} {bar:40} {percent:>3}% {eta}"));
                }
                bar.set_position(percent.into());
            }
            Shown::Line(last) if percent >= *last + PLAIN_STEP => {
                print::message(&format!("{} {percent}%", state.what));
                *last = percent;
            }
            Shown::NotYet | Shown::Line(_) | Shown::Over => {}
        }
    }

    /// Ends it: removes the bar, so that what is printed next starts on a clean line.
    fn clear(&self) {
        if let Some(state) = &self.0
            && let Ok(mut shown) = state.shown.lock()
            && let Shown::Bar(bar) = std::mem::replace(&mut *shown, Shown::Over)
        {
            bar.finish_and_clear();
        }
    }
}

impl State {
    fn show(&self) {
        let Ok(mut shown) = self.shown.lock() else {
            return;
        };
        if matches!(*shown, Shown::Over) {
            return;
        }
        let percent = self.percent.load(Ordering::Relaxed);
        *shown = if std::io::stderr().is_terminal() {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            bar.set_style(style("{msg} {spinner}"));
            bar.set_message(self.what);
            bar.enable_steady_tick(Duration::from_millis(100));
            Shown::Bar(bar)
        } else if percent == UNKNOWN {
            print::message(&format!("{} …", self.what));
            Shown::Line(0)
        } else {
            print::message(&format!("{} {percent}%", self.what));
            Shown::Line(percent)
        };
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

/// The progress of a picture, one bar for each kind of work, from its making to its drop.
pub struct Stages {
    now: Arc<Mutex<Now>>,
    control: Control,
}

struct Now {
    work: Work,
    progress: Progress,
}

impl Stages {
    /// Starts the clock.
    pub fn new(quiet: bool) -> Stages {
        let now = Arc::new(Mutex::new(Now::new(Work::Reading, quiet)));
        let told = now.clone();
        let control = Control::listening(move |work, share| {
            let mut now = told.lock().unwrap_or_else(PoisonError::into_inner);
            if now.work != work {
                *now = Now::new(work, quiet);
            }
            now.progress.update(share);
            ControlFlow::Continue(())
        });
        Stages { now, control }
    }

    /// What tells it how far the work is.
    pub fn control(&self) -> &Control {
        &self.control
    }
}

impl Drop for Stages {
    fn drop(&mut self) {
        let now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        now.progress.clear();
    }
}

impl Now {
    fn new(work: Work, quiet: bool) -> Now {
        let what = match work {
            Work::Reading => "reading",
            Work::Preparing => "preparing",
            Work::Drawing => "drawing",
        };
        Now {
            work,
            progress: Progress::new(what, quiet),
        }
    }
}

/// Control of one kind of work that `progress` shows.
pub fn shown_by(progress: &Progress) -> Control {
    let progress = progress.clone();
    Control::listening(move |_, share| {
        progress.update(share);
        ControlFlow::Continue(())
    })
}
