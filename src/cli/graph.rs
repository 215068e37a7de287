//! `squirm graph`: the stages of a pipeline file and the buffers between them.

use super::{RUN_FAILED, load, print, render};
use squirm::graph::{draw, fused, kernels};
use std::path::Path;
use std::process::ExitCode;

/// What a drawing is made of.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum Format {
    /// A table of characters.
    Terminal,
    /// Graphviz.
    Dot,
    /// Mermaid, which Markdown viewers draw.
    Mermaid,
}

/// Draws a file.
pub fn graph(file: &Path, format: Format, form: super::Form, overrides: &[String]) -> ExitCode {
    let loaded = match load(file, overrides) {
        Ok(loaded) => loaded,
        Err(code) => return code,
    };
    render::all(&loaded.warnings, &loaded.sources);
    let plan = &loaded.plan;
    if form == super::Form::Fused {
        let sizes = fused::sizes(plan, plan.system.particle_count(), None);
        let stages = fused::stages(plan, false);
        let found = fused::items(&stages, fused::Occasion::Next, &sizes)
            .and_then(|items| Ok((items, fused::ahead(plan, &sizes)?)));
        return match found {
            Ok((items, ahead)) => print(&draw::fused((&items, &ahead), &stages, &sizes)),
            Err(error) => invalid(&error),
        };
    }
    let stages: Vec<_> = plan.stages.iter().map(|s| (s.entry, (s.entry.every)(&s.values) == 1)).collect();
    match kernels(&stages) {
        Ok(kernels) => print(&match format {
            Format::Terminal => draw::terminal(&kernels),
            Format::Dot => draw::dot(&plan.name, &kernels),
            Format::Mermaid => draw::mermaid(&kernels),
        }),
        Err(error) => invalid(&error),
    }
}

fn invalid(error: &dyn std::fmt::Display) -> ExitCode {
    say!("error: a shader is not valid: {error}");
    ExitCode::from(RUN_FAILED)
}
