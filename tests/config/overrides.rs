//! Overrides that nobody means never make the parser panic, and every error has a place. Changed files: `squirm-faults pipelines`.

use super::{GOOD, with};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn of_an_override(key in "[a-z0-9_.\\-\"= ]{0,24}", value in "\\PC{0,12}") {
        let argument = format!("{key}={value}");
        if let Err(failure) = with(GOOD, &[&argument]) {
            prop_assert!(failure.diagnostics.iter().any(|d| !d.labels.is_empty()));
        }
    }
}
