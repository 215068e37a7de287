//! What a recording holds, as a table for the terminal.

use squirm::recording::Info;
use std::fmt::Write;

/// Bytes in a unit that fits.
#[allow(clippy::cast_precision_loss)]
fn bytes(n: u64) -> String {
    match n {
        0..10_000 => format!("{n} B"),
        10_000..10_000_000 => format!("{:.1} kB", n as f64 / 1e3),
        10_000_000..10_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.1} GB", n as f64 / 1e9),
    }
}

/// The table; writing into a `String` cannot fail.
pub fn info(info: &Info) -> String {
    let mut text = String::new();
    let known = |value: &Option<String>| value.clone().unwrap_or_else(|| "unknown".into());
    let _ = writeln!(text, "run       {}  (id {})", known(&info.run), known(&info.run_id));
    let _ = writeln!(text, "seed      {}", known(&info.seed));
    let _ = writeln!(text, "version   {}", known(&info.version));
    if let Some([x, y, z]) = info.box_size {
        let _ = writeln!(text, "box       {x} x {y} x {z} a");
    }
    #[allow(clippy::cast_precision_loss)]
    let ratio = info.uncompressed as f64 / info.compressed.max(1) as f64;
    let (before, after) = (bytes(info.uncompressed), bytes(info.compressed));
    let _ = writeln!(text, "data      {before}, compressed to {after} (ratio {ratio:.2})");
    for file in &info.files {
        let end = if file.complete { "" } else { ", without its end" };
        let _ = writeln!(text, "file      {}: {}, {} chunks{end}", file.path.display(), bytes(file.bytes), file.chunks);
    }
    for (name, length) in &info.attachments {
        let _ = writeln!(text, "attached  {name}: {}", bytes(*length));
    }
    let width = info.topics.keys().map(String::len).max().unwrap_or(0).max("topic".len());
    let _ = writeln!(
        text,
        "\n{:width$}  {:>8}  {:>10}  {:>19}  {:>21}",
        "topic", "messages", "size", "steps", "time [tau]"
    );
    for (name, topic) in &info.topics {
        let steps = topic.steps.map_or(String::new(), |[a, b]| format!("{a}..{b}"));
        // Nobody wants to see how a sum of steps was rounded.
        let [a, b] = topic.time.map(|t| (t * 1e9).round() * 1e-9).map(|t| format!("{t:.9}"));
        let [a, b] = [&a, &b].map(|t| t.trim_end_matches('0').trim_end_matches('.'));
        let (count, size, time) = (topic.count, bytes(topic.bytes), format!("{a}..{b}"));
        let _ = writeln!(text, "{name:width$}  {count:>8}  {size:>10}  {steps:>19}  {time:>21}");
    }
    text
}
