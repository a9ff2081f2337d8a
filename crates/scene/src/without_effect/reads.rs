//! What of a scene a technique reads, by the texts of the functions that draw it.

use crate::plan::{Classify, Composite, GradientInput, Plan, Shade, Technique};
use std::collections::BTreeSet;
use strahl_shader::registry::Function;

/// What one technique reads.
pub(super) struct Reads<'p> {
    pub technique: &'p Technique,
    /// Every function that is called, over any number of others.
    pub called: BTreeSet<&'static str>,
    /// Whether a function of a file is among them, of which nobody knows what it calls.
    pub is_open: bool,
}

impl<'p> Reads<'p> {
    pub fn new(plan: &Plan, technique: &'p Technique) -> Reads<'p> {
        let mut reads = Reads {
            technique,
            called: BTreeSet::new(),
            is_open: !plan.modules.is_empty(),
        };
        let mut texts = vec![technique.composite.function().text];
        while let Some(text) = texts.pop() {
            for name in calls(text) {
                if reads.called.insert(name) {
                    texts.extend(reads.text_of(plan, name));
                }
            }
        }
        reads
    }

    /// The text of the function that is called by this name.
    fn text_of(&self, plan: &Plan, name: &str) -> Option<&'static str> {
        let technique = self.technique;
        let field = plan.field();
        Some(match name {
            // What the surroundings of functions call.
            "look" => "shade( illustrate( classify( opacity_of_step(",
            "lighting" => "illuminate( light(",
            "classify" => technique.classify.function().text,
            "gradient" => field.gradient.function().text,
            "gradient_input" => technique.gradient_input.function().text,
            "reconstruct" => field.reconstruct.function().text,
            "fetch" => field.fetch.function().text,
            "shade" => match technique.shade {
                Shade::Unlit => return None,
                Shade::Lit { .. } => Function::find("shade", "lit")?.text,
                Shade::GradientOpacity { .. } => Function::find("shade", "gradient_opacity")?.text,
            },
            "illustrate" => technique.illustrate.function()?.text,
            "illuminate" => match technique.shade {
                Shade::Lit { illuminate, .. } => illuminate.function().text,
                _ => return None,
            },
            _ => return None,
        })
    }

    pub fn calls(&self, function: &str) -> bool {
        self.is_open || self.called.contains(function)
    }

    /// Whether the value of a sample makes a difference beside where it lies.
    pub fn reads_values(&self) -> bool {
        let classifies = || {
            let text = self.technique.classify.function().text;
            words(text).filter(|word| *word == "value").count() > 1
        };
        let text = self.technique.composite.function().text;
        let of_composite = text.matches("sample.value").count();
        let classified = text.matches("classify(sample.value").count();
        let by_gradient = self.called.contains("gradient")
            && self.technique.gradient_input == GradientInput::Value;
        self.is_open
            || by_gradient
            || calls(text).any(|name| name == "reconstruct")
            || of_composite > classified
            || (self.called.contains("classify") && classifies())
    }

    /// Whether colors of the transfer function are seen: views of how a picture is made ask for its opacity only.
    pub fn reads_colors(&self) -> bool {
        let text = self.technique.composite.function().text;
        let own = calls(text).any(|name| name == "look" || name == "classify");
        let shows = own && !matches!(self.technique.composite, Composite::Debug(_));
        self.is_open || (shows && self.reads_table())
    }

    /// Whether opacities of the transfer function make a difference.
    pub fn reads_opacities(&self) -> bool {
        let text = self.technique.composite.function().text;
        let own = calls(text).any(|name| name == "look" || name == "classify");
        // A surface is opaque whatever the transfer function says.
        let shows = own && !matches!(self.technique.composite, Composite::FirstHit { .. });
        let by_gradient = self.called.contains("gradient")
            && self.technique.gradient_input == GradientInput::Opacity;
        // Premultiplied colors are divided by them again.
        let mixes = own && self.technique.classify == Classify::PreClassified;
        self.is_open || ((shows || by_gradient || mixes) && self.reads_table())
    }

    pub fn reads_table(&self) -> bool {
        self.calls("table")
    }

    /// Whether opacities are those of a length.
    pub fn reads_lengths(&self) -> bool {
        self.calls("opacity_of_step")
    }

    /// Whether what is brightest and darkest is looked for in the window.
    pub fn reads_window(&self) -> bool {
        let function = self.technique.composite.function();
        self.is_open || function.parameter("low").is_some()
    }

    /// Whether a gradient makes a difference.
    pub fn reads_gradient(&self) -> bool {
        let is_surface = matches!(self.technique.composite, Composite::FirstHit { .. });
        // A surface is opaque, whatever the gradient makes of its opacity.
        let fades = matches!(self.technique.shade, Shade::GradientOpacity { .. });
        let is_classified = matches!(
            self.technique.classify,
            Classify::GradientTable { .. } | Classify::ValueGradient { .. }
        );
        self.is_open
            || (self.called.contains("gradient") && !(is_surface && fades && !is_classified))
    }

    pub fn composite(&self) -> &'static str {
        self.technique.composite.function().word
    }
}

/// The functions that a text calls.
fn calls(text: &'static str) -> impl Iterator<Item = &'static str> {
    text.lines().flat_map(|line| {
        let code = line.split("//").next().unwrap_or("");
        code.match_indices('(').filter_map(|(at, _)| {
            let before = &code[..at];
            let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let start = before.rfind(|c| !is_word(c)).map_or(0, |i| i + 1);
            // What is declared is not called.
            let declares = before[..start].trim_end().ends_with("fn");
            (start < at && !declares).then_some(&before[start..])
        })
    })
}

/// The words of a text without its comments.
fn words(text: &'static str) -> impl Iterator<Item = &'static str> {
    text.lines().flat_map(|line| {
        let code = line.split("//").next().unwrap_or("");
        code.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
    })
}
