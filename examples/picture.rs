//! Draws the last snapshot of a recording in a slit: the squirmers seen from above, their headings, and the fluid between them.
//!
//! `cargo run --release --example picture -- runs/quickstart/run.mcap picture.svg 5`, where 5 is how many snapshots of the fluid
//! are averaged: thermal noise hides the flow in a single one, and the squirmers move meanwhile.

use squirm::analyze::{Recording, Source};
use squirm::wire::{Fields, Kind, Squirmers};
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::Path;

/// Pixels per cell.
const SCALE: f32 = 24.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(from), Some(to)) = (arguments.next(), arguments.next()) else {
        return Err("give the recording, the picture to write, and how many snapshots to average".into());
    };
    let average = arguments.next().map_or(Ok(1), |n| n.parse::<usize>())?;
    let (mut fields, mut squirmers) = (Vec::new(), None);
    Recording::new(Path::new(&from)).drive(&[Kind::Squirmers, Kind::Fields], &mut |snapshot| {
        if snapshot.expect(Kind::Fields).is_ok() {
            fields.push(Fields::decode(snapshot)?);
        } else {
            squirmers = Some((Squirmers::decode(snapshot)?, snapshot.header.box_size));
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let (squirmers, size) = squirmers.ok_or("the recording has no squirmers")?;
    let [width, height] = [size[0] as f32 * SCALE, size[2] as f32 * SCALE];
    let mut svg = format!("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}'>\n");
    writeln!(svg, "<defs><clipPath id='box'><rect width='{width}' height='{height}'/></clipPath></defs>")?;
    writeln!(svg, "<g clip-path='url(#box)'><rect width='{width}' height='{height}' fill='#f4f7fa'/>")?;
    flow(&mut svg, &fields[fields.len().saturating_sub(average)..])?;
    for (i, (centre, axis)) in squirmers.position.iter().zip(&squirmers.axis).enumerate() {
        let shape = &squirmers.table[squirmers.species[i] as usize];
        // The outline seen along y: half its length is sqrt(b^2 + (a^2 - b^2) s^2) with s the axis' share in the plane.
        let (along, across, s) = (shape.along as f32, shape.across as f32, axis[0].hypot(axis[2]));
        let seen = (across * across + (along * along - across * across) * s * s).sqrt() * SCALE;
        let degrees = axis[2].atan2(axis[0]).to_degrees();
        for (nx, nz) in (-1..=1).flat_map(|x| (-1..=1).map(move |z| (x as f32, z as f32))) {
            let (x, z) = (centre[0] * SCALE + nx * width, centre[2] * SCALE + nz * height);
            writeln!(svg, "<g transform='translate({x:.1} {z:.1}) rotate({degrees:.1})'>")?;
            writeln!(
                svg,
                "<ellipse rx='{seen:.1}' ry='{:.1}' fill='#e07a3f' stroke='#7c3a12' stroke-width='2'/>",
                across * SCALE
            )?;
            let tip = s * along * SCALE * 0.7;
            writeln!(
                svg,
                "<path d='M{:.1} 0H{tip:.1}m-12 -9l13 9l-13 9' fill='none' stroke='#fff' stroke-width='4'/></g>",
                -tip
            )?;
        }
    }
    svg += "</g></svg>\n";
    Ok(std::fs::write(to, svg)?)
}

/// The mean along y: one arrow for each block seen from above, the longest as long as a block and a half; the deeper the colour, the faster.
fn flow(svg: &mut String, fields: &[Fields]) -> std::fmt::Result {
    let Some(first) = fields.first() else { return Ok(()) };
    let [nx, ny, nz] = first.blocks.map(|n| n as usize);
    let mut mean = vec![[0.0f32; 2]; nx * nz];
    for (field, (z, y, x)) in fields
        .iter()
        .flat_map(|f| (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (f, (z, y, x))))))
    {
        let v = field.velocity[(z * ny + y) * nx + x];
        let weight = 1.0 / (ny * fields.len()) as f32;
        mean[z * nx + x][0] += v[0] * weight;
        mean[z * nx + x][1] += v[2] * weight;
    }
    let fastest = mean.iter().map(|v| v[0].hypot(v[1])).fold(1e-9, f32::max);
    let block = first.block as f32 * SCALE;
    for (i, v) in mean.iter().enumerate() {
        let (x, z) = ((i % nx) as f32 * block, (i / nx) as f32 * block);
        let share = v[0].hypot(v[1]) / fastest;
        writeln!(
            svg,
            "<rect x='{x}' y='{z}' width='{block}' height='{block}' fill='#3b7ea6' fill-opacity='{:.3}'/>",
            0.55 * share
        )?;
        let degrees = v[1].atan2(v[0]).to_degrees();
        let length = 1.5 * block * share;
        writeln!(
            svg,
            "<path transform='translate({:.1} {:.1}) rotate({degrees:.0})' d='M{:.1} 0H{:.1}m-6 -5l7 5l-7 5' fill='none' stroke='#1d4d6b' stroke-width='2'/>",
            x + block / 2.0,
            z + block / 2.0,
            -length / 2.0,
            length / 2.0
        )?;
    }
    Ok(())
}
