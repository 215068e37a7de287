//! A fluid read from a table: CSV with the header x,y,z,vx,vy,vz.

use super::StartError;
use super::fluid::Bodies;
use super::image::{lengths, periodic, wrap};
use crate::math::fixed::Scales;
use crate::state::{Particle, Squirmer, System};
use glam::DVec3;
use std::io::BufRead;
use std::path::Path;

const HEADER: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];

/// The particles of a file. Positions are taken into the periodic box; those beyond walls or inside squirmers are refused.
///
/// # Errors
/// If the file cannot be read, or a line is not six finite numbers of a particle in the fluid; the error names the line.
pub fn from_csv(path: &Path, system: &System, squirmers: &[Squirmer]) -> Result<Vec<Particle>, StartError> {
    let file = std::fs::File::open(path).map_err(|e| StartError::Table {
        path: path.display().to_string(),
        line: 0,
        reason: e.to_string(),
    })?;
    read(std::io::BufReader::new(file), system, squirmers).map_err(|(line, reason)| StartError::Table {
        path: path.display().to_string(),
        line,
        reason,
    })
}

fn read(from: impl BufRead, system: &System, squirmers: &[Squirmer]) -> Result<Vec<Particle>, (u64, String)> {
    let bodies = Bodies::new(system, squirmers);
    let mut particles = Vec::new();
    let mut header = false;
    for (number, line) in (1..).zip(from.lines()) {
        let line = line.map_err(|e| (number, e.to_string()))?;
        // Spreadsheets begin a file with a byte order mark.
        let fields = || line.trim_start_matches('\u{feff}').split(',').map(str::trim);
        if line.trim().is_empty() {
            continue;
        }
        if header {
            particles.push(particle(fields(), system, &bodies).map_err(|reason| (number, reason))?);
        } else if fields().eq(HEADER) {
            header = true;
        } else {
            return Err((number, format!("the header must be {}, not {line}", HEADER.join(","))));
        }
    }
    Ok(particles)
}

fn particle<'a>(fields: impl Iterator<Item = &'a str>, system: &System, bodies: &Bodies) -> Result<Particle, String> {
    let mut numbers = [0.0f64; 6];
    let fields: Vec<&str> = fields.collect();
    if fields.len() != numbers.len() {
        return Err(format!("{} fields, not {}", fields.len(), numbers.len()));
    }
    for ((number, text), name) in numbers.iter_mut().zip(fields).zip(HEADER) {
        *number = text.parse().map_err(|_| format!("{name} = `{text}` is not a number"))?;
        if !number.is_finite() {
            return Err(format!("{name} = {text} is not finite"));
        }
    }
    let [x, y, z, vx, vy, vz] = numbers;
    let position = wrap(&system.domain, DVec3::new(x, y, z));
    let (l, periodic) = (lengths(&system.domain), periodic(&system.domain));
    if !periodic[1] && !(0.0..l.y).contains(&y) {
        return Err(format!("y = {y} lies beyond the walls at 0 and {}", l.y));
    }
    if let Some(squirmer) = bodies.containing(position) {
        return Err(format!("({x}, {y}, {z}) lies inside squirmer {squirmer}"));
    }
    let velocity = DVec3::new(vx, vy, vz);
    match speed_problem(velocity, system) {
        Some(reason) => Err(reason),
        None => Ok(Particle { position, velocity }),
    }
}

/// What is wrong with a velocity that the sums over a cell do not hold: a run would stop at its first step.
#[must_use]
pub fn speed_problem(velocity: DVec3, system: &System) -> Option<String> {
    let most = Scales::new(system.fluid.density, system.fluid.temperature).max_speed;
    let speed = velocity.length();
    let rounded = (speed * 1e4).round() / 1e4;
    (speed > most).then(|| format!("the speed {rounded} is above {most}, the largest at this temperature"))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{species, system};
    use super::*;

    fn parse(text: &str) -> Result<Vec<Particle>, (u64, String)> {
        let mut system = system([20, 10, 20], true);
        system.species = vec![species(1, 4.0, 2.0)];
        system.species[0].start = "listed".into();
        system.species[0].poses = Some(vec![[10.0, 5.0, 10.0, 1.0, 0.0, 0.0]]);
        let squirmers = super::super::start(&system).expect("one squirmer fits").squirmers;
        read(text.as_bytes(), &system, &squirmers)
    }

    #[test]
    fn particles_are_read_and_wrapped() {
        let particles =
            parse("\u{feff}x,y,z,vx,vy,vz\r\n1,2,3,4,5,6\n -1, 9.5, 21, 0, 0, -1e-3\n").expect("both are in the fluid");
        assert_eq!(particles[0], Particle { position: DVec3::new(1.0, 2.0, 3.0), velocity: DVec3::new(4.0, 5.0, 6.0) });
        assert_eq!(particles[1].position, DVec3::new(19.0, 9.5, 1.0));
    }

    #[test]
    fn faults_name_their_line() {
        let cases = [
            ("a,b\n", 1, "header"),
            ("x,y,z,vx,vy,vz\n1,2,3,4,5,6\n1,2,3,4,5\n", 3, "fields"),
            ("x,y,z,vx,vy,vz\n1,2,3,4,x,6\n", 2, "vy = `x`"),
            ("x,y,z,vx,vy,vz\n1,2,3,4,inf,6\n", 2, "finite"),
            ("x,y,z,vx,vy,vz\n\n1,10,3,4,5,6\n", 3, "beyond the walls"),
            ("x,y,z,vx,vy,vz\n1,2,3,0,0,24\n1,2,3,0,-24,2\n", 3, "the speed 24.0832 is above 24"),
            ("x,y,z,vx,vy,vz\n13.9,5,10,0,0,0\n", 2, "inside squirmer 0"),
        ];
        for (text, line, reason) in cases {
            let (found, message) = parse(text).expect_err(text);
            assert_eq!(found, line, "{message}");
            assert!(message.contains(reason), "{message}");
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let e =
            from_csv(Path::new("/nowhere/particles.csv"), &system([8, 8, 8], false), &[]).expect_err("no such file");
        assert!(e.to_string().contains("/nowhere/particles.csv"));
    }
}
