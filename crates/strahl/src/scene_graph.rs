//! The graph of a scene: read, edited, compiled, with the pictures that it reads.

use crate::Error;
use crate::confinement::{Confinement, open_regular};
use crate::note::Note;
use crate::picture::CarriedFiles;
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::Path;
use strahl_graph::{
    CompiledGraph, Compiler, Edit, EditList, EditedGraph, GraphUse, MOST_GRAPH_BYTES, Patterns,
    Problem, Texture, edited, pre_integrated, standard, unfolded,
};
use strahl_program::{Functions, Table2d};
use strahl_scene::plan::Plan;
use strahl_scene::{GraphText, Rendered, linear_from_srgb};
use strahl_shader::{RayLoop, Texels};
use strahl_volume::Control;

/// Texels of one picture.
const MOST_TEXELS: u64 = 1 << 26;

/// What a scene asks of the graph that draws it, with everything but pictures read.
#[derive(Clone, Debug)]
pub struct SceneGraph {
    /// What messages call it.
    name: String,
    asked: GraphUse,
    patterns: Patterns,
    /// Its folders of patterns, and its textures.
    carried: CarriedFiles,
}

/// The text `text` of a graph with every graph and WGSL file that it names inside it, read from `folder`, and each of
/// its other paths changed by `change`.
pub(crate) fn with_paths(
    name: &str,
    text: &str,
    folder: &Path,
    confinement: Option<&Confinement>,
    change: impl FnMut(&mut String),
) -> Result<GraphText, Error> {
    let mut asked = read(name, text, folder, confinement)?;
    asked.for_each_path_mut(change);
    GraphText::new(asked.to_text()).map_err(|why| Error::not_usable(Path::new(name), why))
}

/// A graph ready to be drawn.
#[derive(Clone, Debug)]
pub struct ReadyGraph {
    /// The program and its parameters.
    pub compiled: CompiledGraph,
    /// What it reads beside the scene's data.
    pub textures: Vec<Table2d>,
    /// What is odd, but no error: conflicts between edits, nodes that nothing needs.
    pub notes: Vec<String>,
}

/// A renderer of linked programs.
pub(crate) trait ProgramRenderer {
    /// How it reads the volumes of `plan`, and the functions that draw them.
    fn reads(&self, plan: &Plan) -> Result<(RayLoop, Functions), Error>;

    /// Draws `plan` by the program of a graph.
    fn draw_by(
        &mut self,
        plan: &Plan,
        ready: &ReadyGraph,
        control: &Control,
    ) -> Result<Rendered, Error>;
}

/// The same for each of them: their functions have the same names.
macro_rules! draws_programs {
    () => {
        fn reads(&self, plan: &Plan) -> Result<(RayLoop, Functions), Error> {
            Ok((self.loop_of(plan)?, self.functions(plan)?))
        }

        fn draw_by(
            &mut self,
            plan: &Plan,
            ready: &ReadyGraph,
            control: &Control,
        ) -> Result<Rendered, Error> {
            let ReadyGraph {
                compiled, textures, ..
            } = ready;
            let (program, parameters) = (&compiled.program, &compiled.parameters);
            Ok(match &compiled.slicing {
                None => self.render_by(plan, program, parameters, textures, control)?,
                Some(slicing) => {
                    self.render_slices_by(plan, program, parameters, textures, slicing, control)?
                }
            })
        }
    };
}

impl ProgramRenderer for strahl_evaluate::Evaluator {
    draws_programs!();
}

#[cfg(feature = "gpu")]
impl ProgramRenderer for strahl_gpu::Renderer {
    draws_programs!();
}

impl SceneGraph {
    /// From a scene's key `graph`, or from nothing: then it is the standard graph. Its paths count from the
    /// current folder. `name` is what messages call it.
    ///
    /// # Errors
    /// The text is wrong, or a file that it names cannot be read.
    pub fn new(name: &str, text: Option<&GraphText>) -> Result<SceneGraph, Error> {
        SceneGraph::with_carried(name, text, &CarriedFiles::default())
    }

    /// The same, with `carried` files that are used instead of those at their paths.
    pub(crate) fn with_carried(
        name: &str,
        text: Option<&GraphText>,
        carried: &CarriedFiles,
    ) -> Result<SceneGraph, Error> {
        let mut asked = match text {
            Some(text) => read(name, text.as_str(), Path::new(""), None)?,
            None => GraphUse::default(),
        };
        let mut patterns = Patterns::new();
        let mut found = CarriedFiles::default();
        for folder in &asked.patterns {
            let files = match carried.folder(folder) {
                Some(files) => files.clone(),
                None => files_in(folder)?,
            };
            add_patterns(&mut patterns, folder, &files)?;
            found.add_folder(folder, &files);
        }
        asked.for_each_path_mut(|path| {
            if let Some(bytes) = carried.file(path) {
                found.add_file(path, bytes);
            } else if let Some(bytes) = file_to_carry(Path::new(path)) {
                found.add_file(path, &bytes);
            }
        });
        Ok(SceneGraph {
            name: name.to_owned(),
            asked,
            patterns,
            carried: found,
        })
    }

    /// Its folders of patterns, and its textures.
    pub(crate) fn carried(&self) -> &CarriedFiles {
        &self.carried
    }

    /// The graph that draws `plan`, after all edits, and where these want the same place.
    ///
    /// # Errors
    /// The settings have no standard graph, or an edit cannot be carried out.
    pub fn graph(&self, plan: &Plan) -> Result<EditedGraph, Error> {
        let graph = match &self.asked.graph {
            Some(graph) => graph.clone(),
            None => standard(plan)?,
        };
        edited(graph, &self.asked.edits, &self.patterns).map_err(|problems| self.wrong(problems))
    }

    /// The program that draws `plan` by its graph, for a renderer that reads volumes as `what` says.
    ///
    /// # Errors
    /// Everything that is wrong with the graph; a picture that cannot be read.
    pub fn ready(
        &self,
        plan: &Plan,
        what: &RayLoop,
        functions: &Functions,
    ) -> Result<ReadyGraph, Error> {
        let EditedGraph { graph, conflicts } = self.graph(plan)?;
        let mut compiler = Compiler::new(self.patterns.clone());
        let compiled = compiler
            .compile(&self.name, &graph, what, functions)
            .map_err(|error| self.with_culprit(error, plan, what, functions))?;
        let mut textures = Vec::new();
        for (node, texture, object) in &compiled.textures {
            textures.push(self.table(plan, node, texture, *object)?);
        }
        // What edits leave unused of the standard graph is no mistake of theirs.
        let standard_nodes = match &self.asked.graph {
            Some(_) => Vec::new(),
            None => (unfolded(&standard(plan)?).map_err(|problems| self.wrong(problems))?)
                .nodes
                .into_iter()
                .map(|node| format!("nodes.{}", node.name))
                .collect(),
        };
        let warnings = (compiled.warnings.iter()).filter(|w| !standard_nodes.contains(&w.place));
        let odd = conflicts.iter().chain(warnings);
        Ok(ReadyGraph {
            notes: odd
                .map(|problem| format!("{}: {problem}", self.name))
                .collect(),
            compiled,
            textures,
        })
    }

    /// `error`, which first names the list of edits after which the graph of these settings cannot be drawn.
    fn with_culprit(
        &self,
        error: strahl_graph::Error,
        plan: &Plan,
        what: &RayLoop,
        functions: &Functions,
    ) -> strahl_graph::Error {
        let strahl_graph::Error::Graph { file, mut problems } = error else {
            return error;
        };
        let fails = |lists: &[EditList]| {
            let edited = standard(plan)
                .ok()
                .and_then(|graph| edited(graph, lists, &self.patterns).ok());
            let mut compiler = Compiler::new(self.patterns.clone());
            edited.is_some_and(|edited| {
                (compiler.compile(&self.name, &edited.graph, what, functions)).is_err()
            })
        };
        let lists = &self.asked.edits;
        // The message about a node that a list adds names the cause already.
        let is_added = |problem: &Problem| {
            let commands = lists.iter().flat_map(|list| &list.commands);
            let mut added = commands.filter_map(|command| match command {
                Edit::Add(nodes) => Some(nodes),
                _ => None,
            });
            let place = problem.place.strip_prefix("nodes.");
            let name = place.and_then(|rest| rest.split('.').next());
            added.any(|nodes| nodes.iter().any(|node| Some(node.name.as_str()) == name))
        };
        if problems.iter().all(is_added) {
            return strahl_graph::Error::Graph { file, problems };
        }
        let culprit = (0..lists.len()).find(|last| fails(&lists[..=*last]));
        if let (Some(culprit), None) = (culprit, &self.asked.graph) {
            let method = plan.technique().composite.function().word;
            let why = format!(
                "this edit makes a graph of method {method} that cannot be drawn; with another method, nodes may lie elsewhere, inside or outside of loops"
            );
            let place = format!("edits.{}", lists[culprit].name);
            problems.insert(0, Problem::new(place, why));
        }
        strahl_graph::Error::Graph { file, problems }
    }

    /// Draws `plan` by its graph, with what is odd about that.
    pub(crate) fn draw<R: ProgramRenderer>(
        &self,
        renderer: &mut R,
        plan: &Plan,
        control: &Control,
    ) -> Result<(Rendered, Vec<Note>), Error> {
        let (what, functions) = renderer.reads(plan)?;
        let ready = self.ready(plan, &what, &functions)?;
        let rendered = renderer.draw_by(plan, &ready, control)?;
        Ok((rendered, ready.notes.into_iter().map(Note::Data).collect()))
    }

    /// The program where the texture unit interpolates the volumes; no device is needed.
    ///
    /// # Errors
    /// As [`SceneGraph::ready`].
    pub fn program(&self, plan: &Plan) -> Result<ReadyGraph, Error> {
        let functions = Functions::of(plan, true, |_, threshold| f64::from(threshold))?;
        self.ready(
            plan,
            &strahl_program::loop_of(plan, Texels::Float),
            &functions,
        )
    }

    /// The patterns that its nodes can be.
    pub fn patterns(&self) -> &Patterns {
        &self.patterns
    }

    fn wrong(&self, problems: Vec<Problem>) -> Error {
        Error::Graph(strahl_graph::Error::Graph {
            file: self.name.clone(),
            problems,
        })
    }

    fn table(
        &self,
        plan: &Plan,
        node: &str,
        texture: &Texture,
        object: usize,
    ) -> Result<Table2d, Error> {
        let wrong =
            |why: String| self.wrong(vec![Problem::new(format!("nodes.{node}.texture"), why)]);
        match texture {
            Texture::File(path) => picture(Path::new(path), self.carried.file(path)),
            Texture::Texels {
                width,
                height,
                texels,
            } => {
                let needed = u64::from(*width) * u64::from(*height);
                if needed == 0 || needed != texels.len() as u64 {
                    return Err(wrong(format!(
                        "size {width} × {height} needs {needed} texels, at least one; {} are given",
                        texels.len()
                    )));
                }
                Ok(Table2d {
                    width: *width,
                    height: *height,
                    texels: texels.clone(),
                })
            }
            Texture::PreIntegrated { edge } => {
                let most = strahl_graph::MOST_EDGE;
                if !(2..=most).contains(edge) {
                    return Err(wrong(format!(
                        "{edge} columns and rows; allowed: 2 to {most}"
                    )));
                }
                let technique = match plan.labeled() {
                    Some(_) => plan.techniques.get(object),
                    None => (plan.layers.get(object)).map(|_| plan.technique_of(object)),
                };
                match technique {
                    Some(technique) => Ok(pre_integrated(
                        &technique.table,
                        plan.lattice.step_mm,
                        *edge,
                    )),
                    None => Err(wrong(format!("there is no object {object}"))),
                }
            }
        }
    }
}

/// What the text of a graph asks for; files that it names lie in `folder`.
pub(crate) fn read(
    name: &str,
    text: &str,
    folder: &Path,
    confinement: Option<&Confinement>,
) -> Result<GraphUse, Error> {
    Ok(GraphUse::read(name, text, &mut |path| {
        let path = folder.join(path);
        let allowed = confinement.map_or(Ok(()), |confinement| confinement.check(&path));
        allowed.map_err(|error| error.to_string())?;
        text_of(&path).map_err(|error| error.to_string())
    })?)
}

fn text_of(path: &Path) -> Result<String, std::io::Error> {
    let mut bytes = Vec::new();
    open_regular(path)?
        // One more, so that the parser sees what is too long and has the words for it.
        .take(MOST_GRAPH_BYTES as u64 + 1)
        .read_to_end(&mut bytes)?;
    String::from_utf8(bytes).map_err(|_| std::io::Error::other("it is no text in UTF-8"))
}

/// Adds every `NAME.wgsl` of a folder, in the order of the names.
fn add_patterns(
    patterns: &mut Patterns,
    folder: &str,
    files: &BTreeMap<String, Vec<u8>>,
) -> Result<(), Error> {
    for (name, text) in files {
        let file = Path::new(folder).join(name);
        let text = std::str::from_utf8(text)
            .map_err(|_| Error::not_usable(&file, "a pattern is text in UTF-8"))?;
        let stem = name.strip_suffix(".wgsl").unwrap_or(name);
        let file = file.display().to_string();
        patterns.add(stem, &file, text).map_err(|problem| {
            Error::Graph(strahl_graph::Error::Graph {
                file: folder.to_owned(),
                problems: vec![problem],
            })
        })?;
    }
    Ok(())
}

/// Name and text of every WGSL file of a folder.
fn files_in(folder: &str) -> Result<BTreeMap<String, Vec<u8>>, Error> {
    let folder = Path::new(folder);
    let fail = |error| Error::path(folder, error);
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if path.extension().is_some_and(|e| e == "wgsl") {
            let text = text_of(&path).map_err(|error| Error::path(&path, error))?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            files.insert(name.into_owned(), text.into_bytes());
        }
    }
    Ok(files)
}

/// The content of a texture; `None` if it is too long to be carried, or cannot be read, which is an error where it is
/// drawn.
fn file_to_carry(path: &Path) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let limit = crate::picture::MOST_CARRIED_BYTES as u64;
    let file = open_regular(path).ok()?;
    file.take(limit + 1).read_to_end(&mut bytes).ok()?;
    (bytes.len() as u64 <= limit).then_some(bytes)
}

/// A PNG as linear colors.
fn picture(path: &Path, carried: Option<&[u8]>) -> Result<Table2d, Error> {
    if let Some(bytes) = carried {
        return texels(path, std::io::Cursor::new(bytes));
    }
    let file = open_regular(path).map_err(|error| Error::path(path, error))?;
    texels(path, std::io::BufReader::new(file))
}

fn texels(path: &Path, png: impl std::io::BufRead + std::io::Seek) -> Result<Table2d, Error> {
    let wrong = |why: String| Error::not_usable(path, why);
    let mut decoder = png::Decoder::new(png);
    decoder.set_transformations(
        png::Transformations::EXPAND | png::Transformations::STRIP_16 | png::Transformations::ALPHA,
    );
    let mut reader = decoder
        .read_info()
        .map_err(|error| wrong(format!("no PNG: {error}")))?;
    let (width, height) = (reader.info().width, reader.info().height);
    if u64::from(width) * u64::from(height) > MOST_TEXELS {
        return Err(wrong(format!(
            "{width} × {height} pixels; a texture has at most {MOST_TEXELS}"
        )));
    }
    let bytes = reader
        .output_buffer_size()
        .ok_or_else(|| wrong("it is too large".to_owned()))?;
    let mut pixels = Vec::new();
    if pixels.try_reserve_exact(bytes).is_err() {
        return Err(wrong(format!("there is no memory for its {bytes} bytes")));
    }
    pixels.resize(bytes, 0);
    let frame = reader
        .next_frame(&mut pixels)
        .map_err(|error| wrong(format!("a damaged PNG: {error}")))?;
    let linear = |byte: u8| linear_from_srgb(f64::from(byte) / 255.0) as f32;
    let part = |byte: u8| f32::from(byte) / 255.0;
    let texels = match frame.color_type {
        png::ColorType::GrayscaleAlpha => (pixels.chunks_exact(2))
            .map(|p| [linear(p[0]), linear(p[0]), linear(p[0]), part(p[1])])
            .collect(),
        _ => (pixels.chunks_exact(4))
            .map(|p| [linear(p[0]), linear(p[1]), linear(p[2]), part(p[3])])
            .collect(),
    };
    Ok(Table2d {
        width,
        height,
        texels,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_linear() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("two.png");
        let mut encoder = png::Encoder::new(fs::File::create(&path).unwrap(), 2, 1);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&[255, 0, 188, 0, 0, 0]).unwrap();
        writer.finish().unwrap();
        let table = picture(&path, None).unwrap();
        assert_eq!((table.width, table.height, table.texels.len()), (2, 1, 2));
        assert!(
            (table.texels[0][2] - 0.5029).abs() < 1e-3,
            "{:?}",
            table.texels
        );
        assert_eq!(table.texels[0][3], 1.0);
    }
}
