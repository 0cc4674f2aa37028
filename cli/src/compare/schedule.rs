//! The order of measurements: the first to be measured are the last to be dropped.

use lighting::methods::Role;

/// The facts on which the turn of a candidate depends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// The role of the method in the comparison.
    pub(crate) role: Role,
    /// Whether it is the lowest or the highest quality of its method.
    pub(crate) is_end: bool,
}

/// The order in which candidates are measured, by index.
///
/// When time is short, the last are dropped. Repetitions come after all of these;
/// so what is dropped is, in this order: repetitions, qualities between the ends,
/// methods that are neither a paper's nor the baseline. Within each of these the
/// order of the registry stays.
pub(crate) fn order(places: &[Place]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by_key(|index| {
        let Place { role, is_end } = places[*index];
        (!is_end, matches!(role, Role::Engine | Role::Variant))
    });
    order
}

/// Runs through candidates in this order as long as there is time for the next one,
/// and goes on with those that take less.
///
/// `left` is the time that is left, `expected` the time that a candidate will take; `run` runs
/// it. Candidates for which there was no time are returned with the time that was expected.
pub(crate) fn run_while_there_is_time<E>(
    order: &[usize],
    left: impl Fn() -> f64,
    mut expected: impl FnMut(usize) -> Result<f64, E>,
    mut run: impl FnMut(usize) -> Result<(), E>,
) -> Result<Vec<(usize, f64)>, E> {
    let mut dropped = Vec::new();
    for &index in order {
        if left() <= 0.0 {
            dropped.push((index, 0.0));
            continue;
        }
        let seconds = expected(index)?;
        if seconds > left() {
            dropped.push((index, seconds));
        } else {
            run(index)?;
        }
    }
    Ok(dropped)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// Two methods of papers, the baseline and a variant, of three qualities each.
    fn places() -> Vec<Place> {
        let roles = [Role::Baseline, Role::Variant, Role::Paper, Role::Unshadowed];
        let qualities = [true, false, true];
        let of_role = |role| qualities.map(|is_end| Place { role, is_end });
        roles.into_iter().flat_map(of_role).collect()
    }

    /// The candidates that are measured within `seconds`, by a clock that only work moves: each
    /// takes a second.
    fn measured(seconds: f64) -> Vec<usize> {
        let now = Cell::new(0.0);
        let mut done = Vec::new();
        let dropped = run_while_there_is_time::<()>(
            &order(&places()),
            || seconds - now.get(),
            |_| Ok(1.0),
            |index| {
                now.set(now.get() + 1.0);
                done.push(index);
                Ok(())
            },
        );
        assert_eq!(dropped.unwrap().len() + done.len(), 12);
        done.sort_unstable();
        done
    }

    #[test]
    fn qualities_between_the_ends_go_first_then_variants() {
        assert_eq!(measured(12.0).len(), 12);
        // One quality of a variant goes before those of papers.
        assert_eq!(measured(11.0), [0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11]);
        // Only the ends are left.
        assert_eq!(measured(8.0), [0, 2, 3, 5, 6, 8, 9, 11]);
        // Only the ends of papers, of the baseline and without shadows.
        assert_eq!(measured(6.0), [0, 2, 6, 8, 9, 11]);
        assert!(measured(0.0).is_empty());
    }

    #[test]
    fn what_takes_too_long_does_not_stop_what_does_not() {
        let mut done = Vec::new();
        let dropped = run_while_there_is_time::<()>(
            &[0, 1, 2],
            || 1.0,
            |index| Ok(if index == 1 { 5.0 } else { 0.5 }),
            |index| {
                done.push(index);
                Ok(())
            },
        );
        assert_eq!(dropped, Ok(vec![(1, 5.0)]));
        assert_eq!(done, [0, 2]);
    }
}
