//! `strahl presets`: the built-in looks.

use crate::flags::PresetsFlags;
use crate::print;
use anyhow::Result;
use serde_json::json;
use std::fmt::Write;
use strahl::presets;
use strahl::scene::PresetInfo;

pub fn run(flags: &PresetsFlags) -> Result<()> {
    if let Some(preset) = flags.name.as_deref().and_then(PresetInfo::find) {
        return print::out(preset.text());
    }
    if flags.json {
        let list: Vec<_> = presets()
            .iter()
            .map(|p| json!({"name": p.name, "description": p.description, "scene": p.scene()}))
            .collect();
        return print::out(&(serde_json::to_string_pretty(&list)? + "\n"));
    }
    let width = presets().iter().map(|p| p.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for preset in presets() {
        let _ = writeln!(text, "{:width$}  {}", preset.name, preset.description);
    }
    print::out(&text)
}
