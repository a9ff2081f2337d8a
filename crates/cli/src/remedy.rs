//! What a user can do about an error, in terms of command-line flags, which libraries do not know.

#[cfg(feature = "gpu")]
use strahl::gpu;
#[cfg(feature = "graph")]
use strahl::program::SlicingError;
use strahl::volume::Remedy;
use strahl::{Error, Note, volume};
#[cfg(feature = "graph")]
use strahl::{evaluate, graph, shader};

/// What to change on the command line to avoid `error`, if anything helps.
pub fn of(error: &anyhow::Error) -> Option<String> {
    error.chain().find_map(|cause| {
        if let Some(error) = cause.downcast_ref::<Error>() {
            return of_picture(error);
        }
        let error = cause.downcast_ref::<volume::Error>()?;
        Some(of_volume(error.remedy()?))
    })
}

fn of_picture(error: &Error) -> Option<String> {
    let remedy = match error {
        Error::Volume(error) => return Some(of_volume(error.remedy()?)),
        #[cfg(feature = "gpu")]
        Error::Gpu(error) => return of_gpu(error),
        #[cfg(feature = "graph")]
        Error::Evaluate(evaluate::Error::NotCovered { .. }) => "draw with --backend gpu",
        #[cfg(feature = "graph")]
        Error::Evaluate(evaluate::Error::Slicing(SlicingError::Depth)) => NO_DEPTH,
        #[cfg(feature = "graph")]
        Error::Evaluate(evaluate::Error::Shader(shader::Error::Sampling { .. }))
        | Error::Shader(shader::Error::Sampling { .. })
        | Error::Graph(graph::Error::Sampling { .. }) => NO_GRAPH,
        Error::Outside { .. } => {
            "--confine FOLDER lets a scene that you trust read in another folder; `/` is everywhere"
        }
        Error::TooMuchTime { .. } => "--max-time SECONDS allows more, --force anything",
        Error::TooMuchMemory { .. } => "--max-memory BYTES allows more, --force anything",
        Error::NoStages => "draw with --backend cpu and without --graph, or without --stages",
        _ => return None,
    };
    Some(remedy.to_owned())
}

/// What to change on the command line because of a note, if anything.
pub fn of_note(note: &Note) -> Option<&'static str> {
    match note {
        Note::GraphEvaluated | Note::FunctionEvaluated { .. } => Some("--backend gpu is faster"),
        Note::UntoldPlaces { .. } => {
            Some("or name the volume after the picture, and labels with --labels")
        }
        Note::SoftwareAdapter { .. } => Some("--backend cpu is faster"),
        _ => None,
    }
}

#[cfg(feature = "gpu")]
const ON_CPU: &str = "draw with --backend cpu";
#[cfg(feature = "graph")]
const NO_GRAPH: &str = "draw with --backend cpu and without --graph";
#[cfg(feature = "graph")]
const NO_DEPTH: &str = "remove --depth";

#[cfg(feature = "gpu")]
fn of_gpu(error: &gpu::Error) -> Option<String> {
    let remedy = match error {
        gpu::Error::NoAdapter
        | gpu::Error::Device { .. }
        | gpu::Error::Lost(_)
        | gpu::Error::TooLarge { .. }
        | gpu::Error::MeshTooLarge { .. }
        | gpu::Error::MaskTooLarge { .. }
        | gpu::Error::LabelsTooLarge { .. }
        | gpu::Error::NoBlending { .. } => ON_CPU,
        gpu::Error::NoSuchAdapter { .. } => "`strahl info --adapters` lists them",
        #[cfg(feature = "graph")]
        gpu::Error::Slicing(SlicingError::Depth) => NO_DEPTH,
        #[cfg(feature = "graph")]
        gpu::Error::Shader(shader::Error::Sampling { .. }) => NO_GRAPH,
        _ => return None,
    };
    Some(remedy.to_owned())
}

fn of_volume(remedy: Remedy) -> String {
    match remedy {
        Remedy::Series => "pick one with --series N".to_owned(),
        Remedy::Component => {
            "pick one with --component K, or --component luminance for colors".to_owned()
        }
        Remedy::Memory => "--max-memory BYTES allows more".to_owned(),
        Remedy::Spacing => "give --spacing X,Y,Z in mm".to_owned(),
        Remedy::AllowGaps => "--allow-gaps resamples to evenly spaced slices".to_owned(),
        Remedy::DimsAndType => {
            "give the layout, for example --dims 256x256x128 --type u8".to_owned()
        }
        Remedy::Type => "give the type of the samples, for example --type u16".to_owned(),
        Remedy::HeaderBytes(bytes) => {
            format!("if the file begins with a header, use --header-bytes {bytes}")
        }
    }
}
