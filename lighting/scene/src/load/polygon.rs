//! Polygons as triangles.
//!
//! Based on: G. Meisters, "Polygons have ears", American Mathematical Monthly
//! 1975, with the projection along the normal of Newell's method (I. Sutherland,
//! R. Sproull and R. Schumacker, "A characterization of ten hidden-surface
//! algorithms", ACM Computing Surveys 1974). A polygon without a simple outline
//! seen along its normal gets triangles too, as many as any other: n − 2.

use glam::{DVec2, DVec3};

/// Tests of a corner against a candidate triangle that are made for one file;
/// polygons beyond that become fans. Some seconds of work: only files made to
/// be slow get there.
const MAX_TESTS: u64 = 1 << 31;

/// Splits the polygons of a file.
#[derive(Debug)]
pub(super) struct Splitter {
    tests_left: u64,
    /// Polygons that were split at their ears.
    pub(super) concave: u64,
    /// Polygons that became fans though they are concave.
    pub(super) given_up: u64,
}

impl Default for Splitter {
    fn default() -> Self {
        Self::with_tests(MAX_TESTS)
    }
}

impl Splitter {
    fn with_tests(tests_left: u64) -> Self {
        Self {
            tests_left,
            concave: 0,
            given_up: 0,
        }
    }

    /// Appends the triangles of a polygon, in its corner order; nothing if it
    /// has fewer than three corners. Corners are indices into `positions` and
    /// known to be there.
    ///
    /// Convex polygons become fans around their first corner. Takes time in
    /// proportion to the number of corners, or to its square for concave ones.
    pub(super) fn split(
        &mut self,
        corners: &[u32],
        positions: &[DVec3],
        triangles: &mut Vec<[u32; 3]>,
    ) {
        if corners.len() <= 3 {
            triangles.extend(<[u32; 3]>::try_from(corners));
            return;
        }
        let places = flatten(corners, positions);
        if is_convex(&places) {
            fan(corners, triangles);
            return;
        }
        self.concave += 1;
        let work = (corners.len() as u64).saturating_pow(2);
        if work > self.tests_left {
            self.concave -= 1;
            self.given_up += 1;
            fan(corners, triangles);
            return;
        }
        let before = triangles.len();
        self.tests_left -= ears(&places, |ear| {
            triangles.push(ear.map(|corner| corners[corner]));
        })
        .min(self.tests_left);
        debug_assert_eq!(triangles.len() - before, corners.len() - 2);
    }
}

fn fan(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    if let [first, rest @ ..] = corners {
        triangles.extend(rest.windows(2).map(|w| [*first, w[0], w[1]]));
    }
}

/// The polygon seen against its normal, counter-clockwise.
fn flatten(corners: &[u32], positions: &[DVec3]) -> Vec<DVec2> {
    let at = |corner: &u32| positions[*corner as usize];
    // Close to the origin, differences of products are exact enough.
    let origin = corners.first().map_or(DVec3::ZERO, at);
    let places: Vec<DVec3> = corners.iter().map(|corner| at(corner) - origin).collect();
    let next = places.iter().cycle().skip(1);
    let normal: DVec3 = places.iter().zip(next).map(|(a, b)| a.cross(*b)).sum();
    let Some(normal) = normal.try_normalize() else {
        return vec![DVec2::ZERO; corners.len()];
    };
    let (right, up) = normal.any_orthonormal_pair();
    places
        .into_iter()
        .map(|place| DVec2::new(place.dot(right), place.dot(up)))
        .collect()
}

/// Twice the signed area of a triangle.
fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Corners that turn to the right by less than this, in radians, are straight:
/// ten times what rounding to `f32` does to the middle of an edge.
const STRAIGHT: f64 = 1e-6;

/// True if no corner turns to the right and the outline goes around once.
fn is_convex(places: &[DVec2]) -> bool {
    let count = places.len();
    let edge = |i: usize| places[(i + 1) % count] - places[i % count];
    let is_right = |a: DVec2, b: DVec2| a.perp_dot(b) < -STRAIGHT * a.length() * b.length();
    let turns = |i: usize| is_right(edge(i), edge(i + 1));
    if (0..count).any(turns) {
        return false;
    }
    // A star turns to the left everywhere too; its fan is turned over in places.
    let spoke = |i: usize| places[i] - places[0];
    !(1..count - 1).any(|i| is_right(spoke(i), spoke(i + 1)))
}

/// Cuts off one ear after the other. Returns the number of tests made.
fn ears(places: &[DVec2], mut emit: impl FnMut([usize; 3])) -> u64 {
    let count = places.len();
    let mut next: Vec<usize> = (0..count).map(|i| (i + 1) % count).collect();
    let mut previous: Vec<usize> = (0..count).map(|i| (i + count - 1) % count).collect();
    let turn = |[a, b, c]: [usize; 3]| area(places[a], places[b], places[c]);
    // Only these can be inside an ear; what is no reflex corner never becomes one.
    let corner = |i: usize, next: &[usize], previous: &[usize]| [previous[i], i, next[i]];
    let mut reflex: Vec<usize> = (0..count)
        .filter(|&i| turn(corner(i, &next, &previous)) <= 0.0)
        .collect();
    let mut tests = 0_u64;
    let (mut at, mut left, mut failed) = (0, count, 0);
    while left > 3 {
        let ear = corner(at, &next, &previous);
        let convex = turn(ear) > 0.0;
        let is_ear = convex && {
            tests += reflex.len() as u64;
            !reflex.iter().any(|&other| is_inside(places, ear, other))
        };
        // An outline that crosses itself may have no ear: then the next corner
        // that turns left is taken, or any at last.
        let is_last_resort = failed >= 2 * left || (failed >= left && convex);
        if is_ear || is_last_resort {
            emit(ear);
            let [before, _, after] = ear;
            next[before] = after;
            previous[after] = before;
            left -= 1;
            failed = 0;
            reflex.retain(|&i| {
                i != at && ((i != before && i != after) || turn(corner(i, &next, &previous)) <= 0.0)
            });
            // Slivers are avoided by going on at the far side of the cut.
            at = next[after];
        } else {
            failed += 1;
            at = next[at];
        }
    }
    emit(corner(at, &next, &previous));
    tests + count as u64
}

/// True if corner `other` lies in the ear or on the edge that the cut makes.
fn is_inside(places: &[DVec2], [a, b, c]: [usize; 3], other: usize) -> bool {
    if [a, b, c].contains(&other) {
        return false;
    }
    let p = places[other];
    let [a, b, c] = [a, b, c].map(|i| places[i]);
    // Two corners in one place touch without crossing.
    if p == a || p == b || p == c {
        return false;
    }
    area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(outline: &[[f64; 3]]) -> (Vec<[u32; 3]>, Vec<DVec3>, Splitter) {
        let positions: Vec<DVec3> = outline.iter().map(|p| DVec3::from_array(*p)).collect();
        let corners: Vec<u32> = (0..positions.len() as u32).collect();
        let (mut splitter, mut triangles) = (Splitter::default(), Vec::new());
        splitter.split(&corners, &positions, &mut triangles);
        (triangles, positions, splitter)
    }

    fn areas(triangles: &[[u32; 3]], positions: &[DVec3]) -> Vec<DVec3> {
        let corner = |t: &[u32; 3], i: usize| positions[t[i] as usize];
        let area = |t: &[u32; 3]| {
            let (a, b, c) = (corner(t, 0), corner(t, 1), corner(t, 2));
            0.5 * (b - a).cross(c - a)
        };
        triangles.iter().map(area).collect()
    }

    /// Turned and shifted, so that no axis is special.
    fn placed(outline: &[[f64; 2]]) -> Vec<[f64; 3]> {
        let turn = glam::DQuat::from_rotation_y(0.7) * glam::DQuat::from_rotation_x(2.1);
        let place = |[x, y]: &[f64; 2]| {
            (turn * DVec3::new(*x, *y, 0.0) + DVec3::new(50.0, -30.0, 20.0)).to_array()
        };
        outline.iter().map(place).collect()
    }

    const L: [[f64; 2]; 6] = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];

    #[test]
    fn an_l_is_covered_once_whichever_corner_it_starts_at() {
        for start in 0..6 {
            for reversed in [false, true] {
                let mut outline = L.to_vec();
                outline.rotate_left(start);
                if reversed {
                    outline.reverse();
                }
                let (triangles, positions, splitter) = split(&placed(&outline));
                assert_eq!((triangles.len(), splitter.concave), (4, 1));
                let areas = areas(&triangles, &positions);
                let whole: DVec3 = areas.iter().sum();
                // No part is turned over, so none covers another.
                let absolute: f64 = areas.iter().map(|a| a.length()).sum();
                assert!((whole.length() - 5.0).abs() < 1e-9, "{start}");
                assert!((absolute - 5.0).abs() < 1e-9, "{start}");
            }
        }
    }

    #[test]
    fn convex_polygons_are_fans_around_their_first_corner() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]];
        let (triangles, _, splitter) = split(&placed(&square));
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!(splitter.concave, 0);
    }

    #[test]
    fn a_comb_of_many_teeth_is_covered_once() {
        let mut outline = vec![[0.0, 0.0], [200.0, 0.0]];
        for tooth in (0..100).rev() {
            let x = 2.0 * f64::from(tooth);
            outline.extend([[x + 2.0, 1.0], [x + 1.0, 5.0 + x], [x, 1.0]]);
        }
        let (triangles, positions, _) = split(&placed(&outline));
        assert_eq!(triangles.len(), outline.len() - 2);
        let areas = areas(&triangles, &positions);
        let expected = 200.0 + (0..100).map(|t| 4.0 + 2.0 * f64::from(t)).sum::<f64>();
        let absolute: f64 = areas.iter().map(|a| a.length()).sum();
        assert!((absolute - expected).abs() < 1e-6, "{absolute} {expected}");
    }

    #[test]
    fn a_polygon_that_is_not_flat_is_split_along_its_mean_plane() {
        let mut outline: Vec<[f64; 3]> = L.iter().map(|[x, y]| [*x, *y, 0.0]).collect();
        for (number, corner) in outline.iter_mut().enumerate() {
            corner[2] = 0.1 * f64::from(number as u32 % 2);
        }
        let (triangles, positions, _) = split(&outline);
        let areas = areas(&triangles, &positions);
        assert!(areas.iter().all(|a| a.z > 0.0), "none is turned over");
        assert!((areas.iter().map(|a| a.z).sum::<f64>() - 5.0).abs() < 1e-9);
    }

    #[test]
    fn outlines_that_are_none_get_their_triangles_too() {
        let star = (0..5).map(|i| DVec2::from_angle(f64::from(i) * 2.513_274_122).to_array());
        let star: Vec<[f64; 2]> = star.collect();
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        let line: Vec<[f64; 2]> = (0..7).map(|i| [f64::from(i), 0.0]).collect();
        let nan = [[0.0, 0.0], [1.0, f64::NAN], [1.0, 0.0], [0.0, 1.0]];
        let same = [[1.0, 1.0]; 9];
        for outline in [&star[..], &bow[..], &line[..], &nan[..], &same[..]] {
            let (triangles, _, _) = split(&placed(outline));
            assert_eq!(triangles.len(), outline.len() - 2);
        }
        for few in [&[][..], &[[0.0; 3]], &[[0.0; 3]; 2]] {
            assert!(split(few).0.is_empty());
        }
    }

    #[test]
    fn work_is_bounded() {
        let positions: Vec<DVec3> = L.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect();
        let mut splitter = Splitter::with_tests(100);
        let mut triangles = Vec::new();
        for _ in 0..50 {
            splitter.split(&[0, 1, 2, 3, 4, 5], &positions, &mut triangles);
        }
        assert!(splitter.concave > 0 && splitter.given_up > 0);
        assert_eq!(triangles.len(), 200);
    }
}
