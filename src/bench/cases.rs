//! The cases of the benchmark: pipeline files that ship, compiled in, with what each changes and its target.

/// What a target is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// ns per fluid particle and step.
    Particle,
    /// ns per step and particle that the whole box would hold, squirmers included.
    FullBox,
    /// Microseconds per step.
    Step,
    /// Time of a step in that of another case.
    Times(&'static str),
}

/// How large a case is, and what is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A cube, of any size.
    Cube,
    /// A slit of the width 60, of any size.
    Slit,
    /// As the case has it.
    Fixed,
    /// Not a step but what outputs cost.
    Outputs,
}

/// One case.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it is, for people.
    pub what: &'static str,
    /// Name and text of its pipeline file.
    pub file: (&'static str, &'static str),
    /// What it changes there.
    pub overrides: &'static [&'static str],
    /// How large it is.
    pub kind: Kind,
    /// What it changes further on a CPU; `None`: too large for one unless it is named.
    pub cpu: Option<&'static [&'static str]>,
    /// What it should not exceed on one H100.
    pub target: Option<(Measure, f64)>,
}

macro_rules! file {
    ($name:literal) => {
        ($name, include_str!(concat!("../../pipelines/", $name)))
    };
}

/// Particles per cell of every case.
const DENSITY: f64 = 10.0;

/// Particles of a fluid case unless others are asked for.
const ON_GPU: f64 = 1e7;
/// The same for a slit: 300 x 60 x 300.
const SLIT_ON_GPU: f64 = 5.4e7;
/// The same on a CPU: 32^3 cells.
const ON_CPU: f64 = 327_680.0;

/// Width of the slit without squirmers.
const WIDTH: f64 = 60.0;

/// What [`Kind::Outputs`] costs at most: squirmers recorded, a tenth of the fluid published and recorded, every 100 steps, in per cent.
pub const OUTPUTS_AT_MOST: [f64; 2] = [2.0, 5.0];

/// A box of which 3,700 prolate bodies (4, 2, 2) fill 10 %.
const CROWDED: &str = "box.size=[136,136,136]";

/// A fluid alone.
const fn fluid(name: &'static str, what: &'static str, overrides: &'static [&'static str], target: f64) -> Case {
    let target = Some((Measure::Particle, target));
    Case { name, what, file: file!("bulk.toml"), overrides, kind: Kind::Cube, cpu: Some(&[]), target }
}

/// Every case, in the order in which they run.
pub const CASES: &[Case] = &[
    fluid(
        "srd-a",
        "SRD-a, periodic: no angular momentum, each cell keeps its energy",
        &["stage.restore-thermostat.angular_momentum=false"],
        0.036,
    ),
    fluid("energy", "SRD+a, periodic: each cell keeps its energy", &[], 0.050),
    fluid(
        "thermostat",
        "SRD+a, periodic: each cell has a thermostat",
        &["stage.restore-thermostat.mode=thermostat"],
        0.050,
    ),
    Case {
        name: "slit",
        what: "SRD+a with a thermostat in a slit with wall ghosts, without squirmers",
        file: file!("poiseuille.toml"),
        overrides: &["fluid.acceleration=[0,0,0]"],
        kind: Kind::Slit,
        cpu: Some(&[]),
        target: Some((Measure::Particle, 0.055)),
    },
    Case {
        name: "slit-800",
        what: "800 pullers in a narrow slit",
        file: file!("slit-800.toml"),
        overrides: &[],
        kind: Kind::Fixed,
        cpu: None,
        target: Some((Measure::FullBox, 0.09)),
    },
    Case {
        name: "crowd-1",
        what: "one squirmer in a large periodic box",
        file: file!("single-squirmer.toml"),
        overrides: &[CROWDED, "squirmers=[{name='a',count=1,semi_axes={along=4.0,across=2.0},b1=0.05}]"],
        kind: Kind::Fixed,
        cpu: None,
        target: None,
    },
    Case {
        name: "crowd-3700",
        what: "3,700 squirmers in the same box, a tenth of its volume",
        file: file!("single-squirmer.toml"),
        overrides: &[CROWDED, "squirmers=[{name='a',count=3700,semi_axes={along=4.0,across=2.0},b1=0.05}]"],
        kind: Kind::Fixed,
        cpu: None,
        target: Some((Measure::Times("crowd-1"), 1.3)),
    },
    Case {
        name: "channel-100",
        what: "100 pullers in a channel flow",
        file: file!("channel-100.toml"),
        overrides: &[],
        kind: Kind::Fixed,
        cpu: None,
        target: Some((Measure::Particle, 0.060)),
    },
    Case {
        name: "small",
        what: "ten pullers in a slit: quickstart with 100 thousand particles",
        file: file!("quickstart.toml"),
        overrides: &["box.size=[32,10,34]", "squirmers.puller.count=10"],
        kind: Kind::Fixed,
        cpu: Some(&[]),
        target: Some((Measure::Step, 60.0)),
    },
    Case {
        name: "recording",
        what: "what outputs cost: slit-800 with and without them",
        file: file!("slit-800.toml"),
        overrides: &["run.steps=2000"],
        kind: Kind::Outputs,
        cpu: None,
        target: None,
    },
];

/// The case of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Case> {
    CASES.iter().find(|c| c.name == name)
}

impl Case {
    /// Whether it can have any size.
    #[must_use]
    pub fn scales(&self) -> bool {
        matches!(self.kind, Kind::Cube | Kind::Slit)
    }

    /// What it changes in its file at about this number of particles, or at its usual size.
    #[must_use]
    pub fn overrides(&self, particles: Option<f64>, cpu: bool) -> Vec<String> {
        let mut list: Vec<String> = self.overrides.iter().map(|s| (*s).to_owned()).collect();
        let usual = match self.kind {
            Kind::Slit if !cpu => SLIT_ON_GPU,
            _ if cpu => ON_CPU,
            _ => ON_GPU,
        };
        let cells = particles.unwrap_or(usual) / DENSITY;
        let edge = |cells: f64| cells.round().max(4.0);
        match self.kind {
            Kind::Cube => {
                let n = edge(cells.cbrt());
                list.push(format!("box.size=[{n},{n},{n}]"));
            }
            Kind::Slit => {
                let n = edge((cells / WIDTH).sqrt());
                list.push(format!("box.size=[{n},{WIDTH},{n}]"));
            }
            Kind::Fixed => {}
            Kind::Outputs if cpu => {
                list.extend(["run.steps=300", "box.size=[36,7,36]", "squirmers.puller.count=8"].map(str::to_owned));
            }
            Kind::Outputs => {}
        }
        list.extend(self.cpu.filter(|_| cpu).unwrap_or_default().iter().map(|s| (*s).to_owned()));
        list
    }

    /// The target in words, for one H100.
    #[must_use]
    pub fn target_text(&self) -> String {
        match self.target {
            None if self.kind == Kind::Outputs => {
                let [squirmers, fluid] = OUTPUTS_AT_MOST;
                format!("{squirmers} % for squirmers, {fluid} % for a tenth of the fluid, every 100 steps")
            }
            None => String::new(),
            Some((measure, at_most)) => format!("{at_most} {}", measure.unit()),
        }
    }
}

impl Measure {
    /// Its unit.
    #[must_use]
    pub fn unit(self) -> String {
        match self {
            Self::Particle => "ns per fluid particle and step".into(),
            Self::FullBox => "ns per step and particle of the box if it were full of fluid".into(),
            Self::Step => "us per step".into(),
            Self::Times(other) => format!("times a step of {other}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_asked_for() {
        let of = |name, particles, cpu| find(name).expect("a case").overrides(particles, cpu).pop().expect("a size");
        assert_eq!(of("energy", None, false), "box.size=[100,100,100]");
        assert_eq!(of("energy", None, true), "box.size=[32,32,32]");
        assert_eq!(of("srd-a", Some(1.3e8), false), "box.size=[235,235,235]");
        assert_eq!(of("slit", None, false), "box.size=[300,60,300]");
        assert_eq!(of("slit", Some(327_680.0), true), "box.size=[23,60,23]");
        assert!(!find("slit-800").expect("a case").scales());
    }

    #[test]
    fn names_are_unique_and_ratios_refer_to_cases_before() {
        for (i, case) in CASES.iter().enumerate() {
            assert_eq!(CASES.iter().filter(|c| c.name == case.name).count(), 1, "{}", case.name);
            if let Some((Measure::Times(other), _)) = case.target {
                assert!(CASES[..i].iter().any(|c| c.name == other), "{other}");
            }
        }
    }
}
