//! Threefry-4x32-20, the counter-based generator that host and shaders share bit for bit.
//!
//! Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11 (2011). It uses additions, rotations
//! and exclusive-ors only, which WGSL has; no state is kept: a number is a function of (key, counter).

const ROTATIONS: [[u32; 2]; 8] = [[10, 26], [11, 21], [13, 27], [23, 5], [6, 20], [17, 11], [25, 10], [18, 20]];
const PARITY: u32 = 0x1BD1_1BDA;

/// Four random words of the counter `counter` under the key `key`.
#[must_use]
pub fn threefry(counter: [u32; 4], key: [u32; 4]) -> [u32; 4] {
    let schedule = [key[0], key[1], key[2], key[3], PARITY ^ key[0] ^ key[1] ^ key[2] ^ key[3]];
    let mut x = counter;
    for (word, k) in x.iter_mut().zip(key) {
        *word = word.wrapping_add(k);
    }
    for round in 0..20 {
        let [a, b] = ROTATIONS[round % 8];
        let (i, j) = if round % 2 == 0 { (1, 3) } else { (3, 1) };
        x[0] = x[0].wrapping_add(x[i]);
        x[i] = x[i].rotate_left(a) ^ x[0];
        x[2] = x[2].wrapping_add(x[j]);
        x[j] = x[j].rotate_left(b) ^ x[2];
        if round % 4 == 3 {
            let s = round / 4 + 1;
            for (n, word) in x.iter_mut().enumerate() {
                *word = word.wrapping_add(schedule[(s + n) % 5]);
            }
            #[allow(clippy::cast_possible_truncation)]
            let count = s as u32;
            x[3] = x[3].wrapping_add(count);
        }
    }
    x
}

/// What a random number is for: part of its key, so that no two uses ever share one. The shaders' constants are made from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// Grid shift.
    Shift = 1,
    /// A cell's collision: its rotation axis, and what its thermostat tries first.
    Collision = 2,
    /// What the thermostat of a cell tries next.
    Thermostat = 3,
    /// Wall ghosts: number, positions, velocities.
    WallGhost = 4,
    /// Squirmer ghosts: positions, velocities.
    SquirmerGhost = 5,
    /// The start of the run, drawn on the host.
    Start = 6,
}

impl Purpose {
    /// Every purpose.
    pub const ALL: &'static [Self] =
        &[Self::Shift, Self::Collision, Self::Thermostat, Self::WallGhost, Self::SquirmerGhost, Self::Start];
}

/// Random numbers of one (seed, purpose, step).
#[derive(Debug, Clone, Copy)]
pub struct Draw {
    key: [u32; 4],
    step: u64,
}

impl Draw {
    /// The generator of this purpose at this step.
    #[must_use]
    pub fn new(seed: u64, purpose: Purpose, step: u64) -> Self {
        #[allow(clippy::cast_possible_truncation)]
        let key = [seed as u32, (seed >> 32) as u32, purpose as u32, (step >> 32) as u32];
        Self { key, step }
    }

    /// Four random words for the owner (cell or squirmer) and index within it.
    #[must_use]
    pub fn words(&self, owner: u32, index: u32, block: u32) -> [u32; 4] {
        #[allow(clippy::cast_possible_truncation)]
        let step = self.step as u32;
        threefry([step, owner, index, block], self.key)
    }

    /// Four numbers uniform in (0, 1).
    #[must_use]
    pub fn uniforms(&self, owner: u32, index: u32, block: u32) -> [f64; 4] {
        self.words(owner, index, block).map(unit)
    }
}

/// A word as a number in (0, 1): the centres of 2^23 equal intervals, all exact in f32.
#[must_use]
pub fn unit(word: u32) -> f64 {
    (f64::from(word >> 9) + 0.5) / f64::from(1u32 << 23)
}

/// A fifth number in (0, 1) from the lower bits of four words whose upper 23 bits have been used.
#[must_use]
pub fn fifth([x, y, z, _]: [u32; 4]) -> f64 {
    unit(x << 23 | (y & 0x1ff) << 14 | (z & 0x1f) << 9)
}

/// What one ghost needs, from one block of words: three numbers in (0, 1) for its place (of 16, 16 and 18 bits) and four for
/// [`normals`](super::draws::normals), of 23 bits for the logarithms and 16 for the angles. All are centres of equal intervals, so that sums of
/// sines and cosines over the angles vanish as they should.
#[must_use]
pub fn seven([x, y, z, w]: [u32; 4]) -> ([f64; 3], [f64; 4]) {
    let of_16 = |bits: u32| (f64::from(bits) + 0.5) / f64::from(1u32 << 16);
    let rest = (f64::from((x & 0x1ff) << 9 | y & 0x1ff) + 0.5) / f64::from(1u32 << 18);
    ([of_16(z & 0xffff), of_16(w & 0xffff), rest], [unit(x), of_16(z >> 16), unit(y), of_16(w >> 16)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers of the authors' Random123 library for threefry4x32 with 20 rounds.
    #[test]
    fn known_answers() {
        assert_eq!(threefry([0; 4], [0; 4]), [0x9c6c_a96a, 0xe17e_ae66, 0xfc10_ecd4, 0x5256_a7d8]);
        assert_eq!(threefry([u32::MAX; 4], [u32::MAX; 4]), [0x2a88_1696, 0x5701_2287, 0xf6c7_446e, 0xa16a_6732]);
        assert_eq!(
            threefry(
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0, 0x082e_fa98, 0xec4e_6c89]
            ),
            [0x59cd_1dbb, 0xb887_9579, 0x86b5_d00c, 0xac8b_6d84]
        );
    }

    type Taken = dyn Fn([u32; 4]) -> Vec<f64>;

    /// What one block of words is taken apart into: every bit goes into one number at most, and all bits of a number count.
    #[test]
    fn parts_of_a_block_share_no_bit() {
        let of_a_cell = |words: [u32; 4]| words.map(unit).into_iter().chain([fifth(words)]).collect::<Vec<_>>();
        let of_a_ghost = |words| {
            let (place, motion) = seven(words);
            place.into_iter().chain(motion).collect::<Vec<_>>()
        };
        let cases: [(&Taken, &[i32]); 2] = [(&of_a_cell, &[23; 5]), (&of_a_ghost, &[16, 16, 18, 23, 16, 23, 16])];
        for (numbers, bits) in cases {
            let none = numbers([0; 4]);
            let mut sums = vec![0.0; bits.len()];
            for bit in 0..128 {
                let mut words = [0u32; 4];
                words[bit / 32] = 1 << (bit % 32);
                let changes: Vec<f64> = numbers(words).iter().zip(&none).map(|(a, b)| a - b).collect();
                assert!(changes.iter().filter(|c| **c != 0.0).count() <= 1, "{bit}: {changes:?}");
                sums.iter_mut().zip(&changes).for_each(|(sum, change)| *sum += change);
            }
            for ((k, n), sum) in none.iter().zip(bits).zip(sums) {
                let step = 0.5f64.powi(*n);
                assert_eq!((*k, sum), (0.5 * step, 1.0 - step));
            }
        }
    }

    #[test]
    fn uniform_mean_and_variance() {
        let draw = Draw::new(7, Purpose::Start, 3);
        let n = 100_000u32;
        let (mut sum, mut square) = (0.0, 0.0);
        for i in 0..n {
            for u in draw.uniforms(1, i, 0) {
                sum += u;
                square += u * u;
            }
        }
        let count = 4.0 * f64::from(n);
        let (mean, second) = (sum / count, square / count);
        // 5 sigma: sigma of the mean is sqrt(1/12/count), of the second moment sqrt(4/45/count).
        assert!((mean - 0.5).abs() < 5.0 * (1.0 / 12.0 / count).sqrt(), "{mean}");
        assert!((second - 1.0 / 3.0).abs() < 5.0 * (4.0 / 45.0 / count).sqrt(), "{second}");
    }
}
