//! wall-ghosts with velocity = "continued": the shear beside the walls, and the ghosts' velocity that follows from it.

use super::*;
use squirm::params::Params;
use squirm::stages::restore_thermostat::RestoreThermostat;
use squirm::stages::rotate::Rotate;
use squirm::stages::wall_ghosts::WallGhosts;
use squirm::state::scene::Moments;

const LOW: DVec3 = DVec3::new(0.2, 0.0, -0.1);
const HIGH: DVec3 = DVec3::new(-0.3, 0.0, 0.4);

fn continued(patch: u32, memory: f64) -> WallGhosts {
    WallGhosts { velocity: "continued".into(), patch, memory }
}

/// A slit of 12 x 6 x 5 cells so thin that few particles are enough, on a grid moved by 0.3 along x and 0.4 along y. Patches of
/// 8 x 8 cells: two along x, of which the second is 4 wide, one along z.
fn thin() -> System {
    let mut system = system([12, 6, 5], 0.1);
    system.domain.walls = walls("no-slip");
    system.fluid.density = 1e-3;
    system
}

fn particle(x: f64, y: f64, velocity: DVec3) -> Particle {
    Particle { position: DVec3::new(x, y, 2.5), velocity }
}

/// One step of the stage for particles that the scene has been given, and the shear that the next one knows from it.
fn seen(stage: &WallGhosts, system: &System, scene: &mut Scene) {
    step(stage, system, scene);
    scene.state.particles.clear();
    step(stage, system, scene);
}

/// One step of the stage.
fn step(stage: &WallGhosts, system: &System, scene: &mut Scene) {
    scene.shift = DVec3::new(0.3, 0.4, 0.0);
    CellReduce::reference(&CellReduce {}, system, scene);
    WallGhosts::reference(stage, system, scene);
}

#[test]
fn the_shear_is_the_slope_of_the_line_through_the_walls_velocity() {
    let along = DVec3::new(0.1, 0.7, 0.0);
    let across = DVec3::new(0.4, -0.7, -0.2);
    let mut scene = scene(
        vec![
            particle(1.0, 0.5, LOW + along),
            // The second layer ends at 2 - 0.4.
            particle(7.6, 1.5, LOW + across),
            particle(1.0, 1.7, LOW + 9.0 * DVec3::X),
            // In the next cell of the moved grid, and so in the second patch.
            particle(7.8, 1.0, LOW - across),
            // At the high wall the second layer begins 1 + 0.4 from it.
            particle(2.0, 6.0 - 1.3, HIGH + along),
            particle(2.0, 6.0 - 1.5, HIGH + 9.0 * DVec3::X),
        ],
        Vec::new(),
    );
    let particles = scene.state.particles.clone();
    seen(&continued(8, 0.0), &thin(), &mut scene);
    let shears: Vec<DVec3> = scene.wall_shear.iter().map(|p| p.shear).collect();
    let square = 0.25 + 2.25;
    assert_eq!(shears.len(), 4);
    assert_near(shears[0], DVec3::new((0.05 + 0.6) / square, 0.0, -0.3 / square), 1e-12);
    assert_near(shears[1], DVec3::new(-0.4, 0.0, 0.2), 1e-12);
    assert_near(shears[2], DVec3::new(0.1 / 1.3, 0.0, 0.0), 1e-12);
    assert_eq!(shears[3], DVec3::ZERO);
    // One patch for the whole wall, for which the least weight is too small to matter, either.
    let one = continued(16384, 0.0);
    scene.state.particles = particles;
    scene.wall_shear.clear();
    scene.wall_seen.clear();
    seen(&one, &thin(), &mut scene);
    assert_eq!(scene.wall_shear.len(), 2);
    assert_near(scene.wall_shear[0].shear, DVec3::new((0.65 - 0.4) / 3.5, 0.0, (-0.3 + 0.2) / 3.5), 1e-12);
}

#[test]
fn averages_forget_exponentially() {
    let (system, memory) = (thin(), 0.5);
    let mut scene = scene(Vec::new(), Vec::new());
    let fresh = 1.0 - (-0.1f64 / memory).exp();
    let (mut sum, mut weights) = (0.0, 0.0);
    for velocity in [0.3, -0.1, 0.0, 0.2] {
        scene.state.particles = vec![particle(1.0, 0.5, LOW + velocity * DVec3::X)];
        step(&continued(8, memory), &system, &mut scene);
        // The present step is not among those that the ghosts know.
        if weights > 0.0 {
            assert_near(scene.wall_shear[0].shear, DVec3::X * sum / weights / 0.5, 1e-12);
        } else {
            assert_eq!(scene.wall_shear[0].shear, DVec3::ZERO);
        }
        sum = (1.0 - fresh) * sum + velocity;
        weights = (1.0 - fresh) * weights + 1.0;
    }
}

/// Where there is less fluid than a quarter of what belongs there the shear counts less: a particle close to the wall does not
/// tell a shear of v/y.
#[test]
fn little_fluid_tells_little_shear() {
    let mut system = thin();
    system.fluid.density = 10.0;
    let mut scene = scene(vec![particle(1.0, 1e-3, LOW + DVec3::X)], Vec::new());
    seen(&continued(8, 0.0), &system, &mut scene);
    // Columns of the first patch: 8 x 5.
    assert_near(scene.wall_shear[0].shear, DVec3::X * 1e-3 / (0.25 * 1.25 * 10.0 * 40.0), 1e-12);
}

/// Fluid with a constant shear at each wall and no thermal motion: every ghost lies on the same line, with velocity = "wall" none.
#[test]
fn ghosts_continue_a_linear_profile() {
    let mut system = system([12, 6, 5], 0.1);
    system.domain.walls = walls("no-slip");
    system.fluid.temperature = 0.0;
    let shear = [DVec3::new(0.3, 0.0, -0.2), DVec3::new(-0.1, 0.0, 0.5)];
    let profile = |y: f64| if y < 3.0 { LOW + y * shear[0] } else { HIGH + (6.0 - y) * shear[1] };
    let mut fluid = gas(&system, 14, 3600);
    fluid.iter_mut().for_each(|p| p.velocity = profile(p.position.y));
    for (stage, slope) in [(continued(8, 0.0), 1.0), (WallGhosts { velocity: "wall".into(), ..continued(8, 0.0) }, 0.0)]
    {
        let mut scene = scene(fluid.clone(), Vec::new());
        // The ghosts of a step continue what the step before has seen.
        step(&stage, &system, &mut scene);
        step(&stage, &system, &mut scene);
        let filled = scene.moments.clone();
        CellReduce::reference(&CellReduce {}, &system, &mut scene);
        let mut ghosts = 0.0;
        for (i, (all, fluid)) in filled.iter().zip(&scene.moments).enumerate() {
            let wall = match system.domain.cell_at(i as u32)[1] {
                0 => 0,
                6 => 1,
                _ => continue,
            };
            let n = all.count - fluid.count;
            // The wall lies 0.4 - 0.5 from the middle of the cell.
            let depth = [-1.0, 1.0][wall] * ((all.x.y - fluid.x.y) + 0.1 * n);
            let expected = n * [LOW, HIGH][wall] - slope * depth * shear[wall];
            assert_near(all.v - fluid.v, expected, 1e-10);
            assert!(depth >= 0.0);
            ghosts += n;
        }
        assert!(ghosts > 400.0, "{ghosts}");
        assert_eq!(scene.wall_shear.is_empty(), slope == 0.0);
    }
}

#[test]
fn walls_gain_what_the_fluid_loses_to_continued_ghosts() {
    let mut system = system([8, 6, 8], 0.1);
    system.domain.walls = walls("no-slip");
    let mut before = gas(&system, 12, 3840);
    before.iter_mut().for_each(|p| p.velocity.x += 0.3 * p.position.y);
    let stages = |velocity: &str| {
        [
            ("wall-ghosts", WallGhosts { velocity: velocity.into(), ..continued(4, 2.0) }.to_values()),
            ("rotate", Rotate { angle: 130.0, grip: 1.22 }.to_values()),
            ("restore-thermostat", RestoreThermostat { mode: "thermostat".into(), angular_momentum: true }.to_values()),
        ]
    };
    let gained = ["continued", "wall"].map(|velocity| {
        let mut scene = scene(before.clone(), Vec::new());
        collide(&system, &mut scene, &stages(velocity));
        collide(&system, &mut scene, &stages(velocity));
        let [low, high] = scene.wall_impulses;
        assert_near(momentum(&scene.state.particles) + low + high, momentum(&before), 1e-10);
        low
    });
    assert!(gained[0].length() > 1.0 && (gained[0] - gained[1]).length() > 0.1, "{gained:?}");
}

/// The number of ghosts, their places and their thermal velocities do not depend on their mean velocity.
#[test]
fn continued_ghosts_are_the_same_but_for_their_mean() {
    let mut system = system([8, 6, 8], 0.1);
    system.domain.walls = walls("no-slip");
    let still = |stage: &WallGhosts| {
        // Without fluid the shear is nothing.
        let mut scene = scene(Vec::new(), Vec::new());
        step(stage, &system, &mut scene);
        scene.moments
    };
    let moments: Vec<Moments> = still(&continued(8, 2.0));
    assert!(moments.iter().map(|m| m.count).sum::<f64>() > 500.0);
    assert_eq!(moments, still(&WallGhosts { velocity: "wall".into(), ..continued(8, 2.0) }));
}
