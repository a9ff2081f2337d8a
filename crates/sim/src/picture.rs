//! A picture as the Spec says: in one run, in slabs, or from several volumes and boards.
//!
//! ```
//! use strahl_sim::{NoObserver, Spec, Subject, VolumeStore, draw, jaw, no_progress};
//!
//! let jaw = VolumeStore::new(&jaw([32, 32, 16])?)?;
//! let spec = Spec::default().with(&["merge.boards=2".to_owned()])?;
//! let drawn = draw(&spec, &Subject::of(&jaw), &mut NoObserver, &no_progress)?;
//! // Both boards work at the same time.
//! assert_eq!(drawn.counters.clocks, *drawn.clocks_of_part.iter().max().unwrap());
//! # Ok::<(), strahl_sim::Error>(())
//! ```

use crate::intermediate_planes::run_slabs;
use crate::merge::Boards;
use crate::observer::Observer;
use crate::processor::{Progress, Run, run};
use crate::spec::Spec;
use crate::subject::Subject;
use crate::{Error, Frame};

/// A picture that is settled: whatever can fail has not failed.
#[derive(Clone, Debug)]
pub struct Picture(Runs);

#[derive(Clone, Debug)]
enum Runs {
    One(Frame),
    Slabs(Frame),
    Boards(Boards),
}

impl Picture {
    /// Settles a picture.
    ///
    /// # Errors
    /// If the Spec contradicts itself, the volumes or the view, or something that it names is not in `subject`.
    pub fn new(spec: &Spec, subject: &Subject) -> Result<Picture, Error> {
        spec.check()?;
        if spec.merge.is_on() {
            return Ok(Picture(Runs::Boards(Boards::new(spec, subject)?)));
        }
        let frame = Frame::with_mesh(spec, subject.volume, subject.mesh.as_ref())?;
        if spec.view.slabs == 1 {
            return Ok(Picture(Runs::One(frame)));
        }
        let planes = frame.setup.plane_count();
        if spec.view.slabs > planes {
            let problem = format!("this view has {planes} planes of samples; at most so many");
            return Err(Error::field("view.slabs", spec.view.slabs, problem));
        }
        Ok(Picture(Runs::Slabs(frame)))
    }

    /// Draws it. Of several runs the observer sees the first: the nearest slab, the first board's first volume.
    ///
    /// # Errors
    /// As [`run`].
    pub fn draw(&self, observer: &mut impl Observer, progress: Progress) -> Result<Run, Error> {
        match &self.0 {
            Runs::One(frame) => run(frame, observer, progress),
            Runs::Slabs(frame) => run_slabs(frame, observer, progress),
            Runs::Boards(boards) => boards.run(observer, progress),
        }
    }
}

/// Settles and draws a picture.
///
/// # Errors
/// As [`Picture::new`].
pub fn draw(
    spec: &Spec,
    subject: &Subject,
    observer: &mut impl Observer,
    progress: Progress,
) -> Result<Run, Error> {
    Picture::new(spec, subject)?.draw(observer, progress)
}
