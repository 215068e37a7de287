//! Draws how the time of a step grows with the fluid and with the squirmers, and prints the table.
//!
//! `squirm bench thermostat --size 1e4,1e5,1e6,1e7,1e8 --json sizes.json` measures, and
//! `cargo run --release --example scaling -- docs sizes.json CROWD.json...` draws `docs/scaling-fluid.svg` from the cases without
//! squirmers and `docs/scaling-squirmers.svg` from those with.

use serde_json::Value;
use squirm::analyze::plot::{Chart, Curve, Scale};
use std::path::Path;

/// One case of a report.
struct Point {
    name: String,
    particles: f64,
    squirmers: f64,
    us: [f64; 3],
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("give the folder for the pictures, and reports of squirm bench --json")?;
    let (mut points, mut adapter) = (Vec::new(), String::new());
    for name in arguments {
        let report: Value = serde_json::from_str(&std::fs::read_to_string(&name)?)?;
        report["adapter"].as_str().ok_or(format!("{name} is no report of squirm bench"))?.clone_into(&mut adapter);
        points.extend(report["cases"].as_array().into_iter().flatten().filter_map(point));
    }
    println!("| case | particles | squirmers | us per step | ns per particle and step |\n|---|---|---|---|---|");
    for p in &points {
        let (us, ns) = (p.us[1], 1e3 * p.us[1] / p.particles);
        println!("| {} | {} | {} | {us:.1} | {ns:.4} |", p.name, p.particles, p.squirmers);
    }
    let (with, without): (Vec<&Point>, Vec<&Point>) = points.iter().partition(|p| p.squirmers > 0.0);
    let fluid = without.iter().map(|p| (p.particles, p.us.map(|us| 1e3 * us / p.particles)));
    draw(
        &folder,
        "scaling-fluid",
        ["particles", "ns per particle and step"],
        (&adapter, Scale::Logarithmic),
        fluid.collect(),
    )?;
    let crowd = with.iter().map(|p| (p.squirmers, p.us));
    draw(&folder, "scaling-squirmers", ["squirmers", "us per step"], (&adapter, Scale::Linear), crowd.collect())?;
    Ok(())
}

fn point(case: &Value) -> Option<Point> {
    let us = |key: &str| case["us_per_step"][key].as_f64();
    Some(Point {
        name: case["case"].as_str()?.into(),
        particles: case["particles"].as_f64()?,
        squirmers: case["squirmers"].as_f64()?,
        us: [us("low")?, us("median")?, us("high")?],
    })
}

/// Medians, with the spread of the batches as bars.
fn draw(
    folder: &str,
    name: &str,
    [x, y]: [&str; 2],
    (adapter, scale): (&str, Scale),
    points: Vec<(f64, [f64; 3])>,
) -> Result<(), Box<dyn std::error::Error>> {
    if points.is_empty() {
        return Ok(());
    }
    let bars = points.into_iter().map(|(x, [low, median, high])| (x, median, (high - low) / 2.0));
    let curve = Curve { name: adapter.into(), points: bars.collect(), ..Curve::default() };
    let title = format!("{y} against {x}");
    let chart = Chart { title, x: x.into(), y: y.into(), scale, curves: vec![curve] };
    std::fs::write(Path::new(folder).join(format!("{name}.svg")), chart.svg()?)?;
    Ok(())
}
