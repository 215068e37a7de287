//! Clusters of known sizes, and number fluctuations with and without correlations.

use super::{chance, close, make, squirmers, stamp, table, take};
use rand::RngExt;
use squirm::params::Value;

/// Spheres of radius 1 in a row along x from a place on, their surfaces `gap` apart.
fn row(from: [f32; 3], count: u16, gap: f32) -> Vec<[f32; 3]> {
    (0..count).map(|i| [(from[0] + f32::from(i) * (2.0 + gap)).rem_euclid(40.0), from[1], from[2]]).collect()
}

#[test]
fn two_clusters_of_known_sizes() {
    // Five in a row across the side of the box, three in a row, two far apart: their surfaces are 0.9 apart within the rows.
    let places = [
        row([34.0, 2.0, 5.0], 5, 0.9),
        row([4.0, 2.0, 30.0], 3, 0.9),
        row([5.0, 2.0, 17.0], 1, 0.0),
        row([30.0, 2.0, 17.0], 1, 0.0),
    ]
    .concat();
    let found = |gap: f64| {
        let mut clusters = make("clusters", &[("gap", Value::Float(gap))]);
        for seq in 0..4 {
            let bytes =
                squirmers(&places, &[[0.0, 1.0, 0.0]; 10], 1.0, 1.0).encode(&stamp(seq, [40.0, 4.0, 40.0], true));
            take(clusters.as_mut(), &bytes).unwrap();
        }
        clusters.finish().unwrap()
    };
    let report = found(1.0);
    let rows: Vec<[f64; 5]> = table(&report, "sizes.csv")
        .iter()
        .map(|r| {
            [
                "size",
                "clusters per snapshot",
                "clusters per snapshot error",
                "share of squirmers",
                "share of squirmers error",
            ]
            .map(|c| r[c])
        })
        .collect();
    assert_eq!(rows, [[1.0, 2.0, 0.0, 0.2, 0.0], [3.0, 1.0, 0.0, 0.3, 0.0], [5.0, 1.0, 0.0, 0.5, 0.0]]);
    for row in table(&report, "time.csv") {
        let found = [
            "squirmers in the largest cluster",
            "clusters",
            "squirmers per cluster",
            "size of the cluster of a squirmer",
        ]
        .map(|c| row[c]);
        assert_eq!(found, [5.0, 4.0, 2.5, (25.0 + 9.0 + 1.0 + 1.0) / 10.0]);
    }
    // Negative control: with a smaller gap nobody has a neighbour.
    let alone = found(0.8);
    assert_eq!(table(&alone, "sizes.csv").len(), 1);
    assert_eq!(table(&alone, "sizes.csv")[0]["clusters per snapshot"], 10.0);
}

#[test]
fn fluctuations_of_counts_are_those_of_the_boxes() {
    // All eight in one corner: of 2 x 2 parts one has 8, three have 0, the mean is 2.
    let mut clusters = make("clusters", &[]);
    let places: Vec<[f32; 3]> = (0..8u16).map(|i| [0.1 + f32::from(i), 2.0, 0.1]).collect();
    let bytes = squirmers(&places, &[[1.0, 0.0, 0.0]; 8], 1.0, 1.0).encode(&stamp(0, [40.0, 4.0, 40.0], true));
    take(clusters.as_mut(), &bytes).unwrap();
    let first = &table(&clusters.finish().unwrap(), "fluctuations.csv")[0];
    assert_eq!(
        [first["parts"], first["edge along x [a]"], first["mean count"], first["variance"]],
        [4.0, 20.0, 2.0, 12.0]
    );
}

#[test]
fn independent_squirmers_fluctuate_as_such_and_pairs_more() {
    for paired in [false, true] {
        let mut rng = chance(21);
        let mut clusters = make("clusters", &[]);
        for seq in 0..256 {
            let mut places: Vec<[f32; 3]> = (0..40).map(|_| [0; 3].map(|_| 30.0 * rng.random::<f32>())).collect();
            if paired {
                (0..20).for_each(|i| places[i + 20] = places[i]);
            }
            let bytes = squirmers(&places, &[[1.0, 0.0, 0.0]; 40], 0.5, 0.5).encode(&stamp(seq, [30.0; 3], false));
            take(clusters.as_mut(), &bytes).unwrap();
        }
        let rows = table(&clusters.finish().unwrap(), "fluctuations.csv");
        assert_eq!(rows.len(), 7);
        for row in &rows {
            // A pair counts twice: its variance is twice that of singles.
            let wanted = row["variance if independent"] * if paired { 2.0 } else { 1.0 };
            close(row["variance"], wanted, 5.0 * row["variance error"]);
            assert!(row["variance error"] < 0.2 * wanted, "{row:?}");
        }
    }
}
