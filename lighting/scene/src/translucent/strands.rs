//! Strands: hair, fur, grass.

use glam::Vec3;

use super::{around, check_colour, check_position, check_size};
use crate::{Bounds, SceneError};

/// A point of a strand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrandPoint {
    /// World position, m.
    pub position: Vec3,
    /// Diameter, m.
    pub thickness: f32,
    /// The share of the light meeting the strand that does not pass it, 0 to 1.
    pub opacity: f32,
}

/// Polygonal lines of round cross-section.
///
/// Between two points of a strand there is a cylinder with their mean thickness and mean
/// opacity. Its ends are open, so light along its axis passes. Light that meets a cylinder
/// anywhere within its outline is reduced to the share `1 − opacity`.
#[derive(Debug, Clone, PartialEq)]
pub struct Strands {
    points: Vec<StrandPoint>,
    ends: Vec<u32>,
    /// The first point of each piece.
    pieces: Vec<u32>,
    /// A colour for each point, or one for all.
    colours: Vec<Vec3>,
    bounds: Option<Bounds>,
}

/// The cylinder between two points of a strand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// The ends of its axis, m.
    pub axis: [Vec3; 2],
    /// Half its thickness, m.
    pub radius: f32,
    /// The share of the light that it holds back.
    pub opacity: f32,
}

impl Strands {
    /// The colour of strands that were given none: brown hair, linear RGB.
    pub const COLOUR: Vec3 = Vec3::new(0.36, 0.21, 0.11);

    /// Strand `i` has the points from `ends[i − 1]` (0 for the first strand) up to but not
    /// including `ends[i]`. A strand of fewer than two points is valid and invisible.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] for a position that is not finite or beyond
    /// 5e8 m, a thickness outside of 0 to 1e8 m, an opacity outside of 0 to 1,
    /// an end before the one in front of it, more than 2²⁶ points;
    /// [`SceneError::LengthMismatch`] if the last end is not the number of
    /// points.
    pub fn new(points: Vec<StrandPoint>, ends: Vec<u32>) -> Result<Self, SceneError> {
        const MAX_POINTS: usize = 1 << 26;
        if points.len() > MAX_POINTS {
            return Err(SceneError::bad_value(
                "strands",
                "the number of points",
                points.len(),
                "at most 2^26",
            ));
        }
        let last = ends.last().copied().unwrap_or(0);
        if last as usize != points.len() {
            return Err(SceneError::LengthMismatch {
                owner: "strands".into(),
                what: "the list of points",
                actual: points.len(),
                expected: last as usize,
            });
        }
        if let Some(pair) = ends.windows(2).find(|pair| pair[1] < pair[0]) {
            return Err(SceneError::bad_value(
                "strands",
                "the end of a strand",
                pair[1],
                "a number that is not below the end in front of it",
            ));
        }
        for (index, point) in points.iter().enumerate() {
            let owner = || format!("strand point {index}");
            check_position(owner, point.position)?;
            check_size(owner, "thickness", point.thickness)?;
            if !(0.0..=1.0).contains(&point.opacity) {
                return Err(SceneError::bad_value(
                    owner(),
                    "opacity",
                    point.opacity,
                    "a number from 0 to 1",
                ));
            }
        }
        let mut pieces = Vec::with_capacity(points.len());
        let mut first = 0;
        for &end in &ends {
            pieces.extend(first..end.saturating_sub(1).max(first));
            first = end;
        }
        let mut strands = Self {
            points,
            ends,
            pieces,
            colours: vec![Self::COLOUR],
            bounds: None,
        };
        // Both ends count with the piece's thickness, which is larger than that of a tapering
        // strand at its thin end.
        let pieces = (0..strands.piece_count()).map(|index| strands.piece(index));
        let ends = pieces.flat_map(|piece| piece.axis.map(|end| (end, piece.radius)));
        strands.bounds = around(ends);
        Ok(strands)
    }

    /// The same strands, scaled by `scale` about the origin, thickness included, and then moved
    /// by `shift`.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if a point or a thickness is then beyond what
    /// [`Strands::new`] takes.
    pub fn placed(&self, shift: Vec3, scale: f32) -> Result<Self, SceneError> {
        let placed = self.points.iter().map(|point| StrandPoint {
            position: shift + scale * point.position,
            thickness: scale * point.thickness,
            ..*point
        });
        let placed = Self::new(placed.collect(), self.ends.clone())?;
        Ok(Self {
            colours: self.colours.clone(),
            ..placed
        })
    }

    /// The same strands in other colours: one for all, or one per point, linear RGB.
    /// A colour is the share of the light that a strand does not absorb, 0 to 1.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] for a colour outside of 0 to 1;
    /// [`SceneError::LengthMismatch`] unless there is one, or as many as points.
    pub fn with_colours(self, colours: Vec<Vec3>) -> Result<Self, SceneError> {
        if colours.len() != 1 && colours.len() != self.points.len() {
            return Err(SceneError::LengthMismatch {
                owner: "strands".into(),
                what: "the list of colours",
                actual: colours.len(),
                expected: self.points.len(),
            });
        }
        for (index, colour) in colours.iter().enumerate() {
            let owner = || format!("strand point {index}");
            let expected = "numbers from 0 to 1";
            check_colour(owner, "colour", *colour, 1.0, expected)?;
        }
        Ok(Self { colours, ..self })
    }

    /// The points of all strands, one after the other.
    pub fn points(&self) -> &[StrandPoint] {
        &self.points
    }

    /// Number of strands.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// True if there are no strands.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Number of pieces of all strands.
    pub fn piece_count(&self) -> usize {
        self.pieces.len()
    }

    /// The piece with this index.
    ///
    /// # Panics
    /// If there is no such piece.
    pub fn piece(&self, index: usize) -> Piece {
        let first = self.pieces[index] as usize;
        let (a, b) = (&self.points[first], &self.points[first + 1]);
        Piece {
            axis: [a.position, b.position],
            radius: 0.25 * (a.thickness + b.thickness),
            opacity: 0.5 * (a.opacity + b.opacity),
        }
    }

    /// The colour of a piece at a share of its length from its first point.
    ///
    /// # Panics
    /// If there are fewer pieces.
    pub fn colour(&self, piece: usize, share: f32) -> Vec3 {
        let first = self.pieces[piece] as usize;
        match self.colours[..] {
            [one] => one,
            ref of_points => of_points[first].lerp(of_points[first + 1], share),
        }
    }

    /// True if the strand of this piece ends with it, so that the next piece is not joined to
    /// it.
    ///
    /// # Panics
    /// If there are fewer pieces.
    pub fn is_last_piece(&self, piece: usize) -> bool {
        let next = self.pieces.get(piece + 1);
        next.is_none_or(|next| *next != self.pieces[piece] + 1)
    }

    /// A box around all pieces; `None` if there are none.
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: usize) -> Vec<StrandPoint> {
        (0..count)
            .map(|i| StrandPoint {
                position: Vec3::X * i as f32,
                thickness: 0.1,
                opacity: 0.5,
            })
            .collect()
    }

    #[test]
    fn pieces_join_the_points_of_one_strand_only() {
        let strands = Strands::new(points(6), vec![0, 3, 4, 6]).unwrap();
        assert_eq!((strands.len(), strands.piece_count()), (4, 3));
        let starts: Vec<f32> = (0..3).map(|i| strands.piece(i).axis[0].x).collect();
        assert_eq!(starts, [0.0, 1.0, 4.0]);
        let none = Strands::new(vec![], vec![]).unwrap();
        assert!(none.is_empty() && none.bounds().is_none());
    }

    #[test]
    fn bounds_hold_the_thin_ends_of_pieces_and_nothing_that_is_invisible() {
        let mut tapered = points(3);
        tapered[0].thickness = 2.0;
        tapered[1].thickness = 0.0;
        tapered[2].position = Vec3::splat(9.0); // a strand of its own
        let bounds = Strands::new(tapered, vec![2, 3]).unwrap().bounds().unwrap();
        let (min, max) = (Vec3::splat(-0.5), Vec3::new(1.5, 0.5, 0.5));
        assert!(bounds.min().cmple(min).all() && bounds.max().cmpge(max).all());
        assert!(bounds.min().abs_diff_eq(min, 1e-5) && bounds.max().abs_diff_eq(max, 1e-5));
        let invisible = Strands::new(points(1), vec![1]).unwrap();
        assert_eq!(invisible.bounds(), None);
    }

    #[test]
    fn colours_run_from_point_to_point_and_are_checked() {
        let strands = || Strands::new(points(4), vec![3, 4]).unwrap();
        assert_eq!(strands().colour(1, 0.5), Strands::COLOUR);
        let one = strands().with_colours(vec![Vec3::X]).unwrap();
        assert_eq!(one.colour(1, 0.3), Vec3::X);
        let each = vec![Vec3::ZERO, Vec3::ONE, Vec3::Z, Vec3::ONE];
        let each = strands().with_colours(each).unwrap();
        assert_eq!(each.colour(0, 0.25), Vec3::splat(0.25));
        assert_eq!(each.colour(1, 0.5), Vec3::new(0.5, 0.5, 1.0));
        assert!(!each.is_last_piece(0) && each.is_last_piece(1));
        for (colours, cause) in [
            (vec![], "0 entries"),
            (vec![Vec3::ONE; 3], "3 entries"),
            (vec![Vec3::new(0.0, 1.5, 0.0)], "1.5"),
            (vec![Vec3::NAN], "NaN"),
        ] {
            let error = strands().with_colours(colours).unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
    }

    #[test]
    fn bad_strands_name_their_cause() {
        let with = |change: fn(&mut StrandPoint)| {
            let mut points = points(2);
            change(&mut points[1]);
            Strands::new(points, vec![2])
        };
        for (strands, cause) in [
            (with(|p| p.position.y = f32::NAN), "point 1"),
            (with(|p| p.position.y = 6e8), "5e8"),
            (with(|p| p.thickness = -0.1), "-0.1"),
            (with(|p| p.opacity = 1.5), "opacity is 1.5"),
            (with(|p| p.opacity = f32::NAN), "NaN"),
            (Strands::new(points(3), vec![2]), "3 entries"),
            (Strands::new(points(3), vec![4, 3]), "3, expected"),
            (Strands::new(points(1), vec![]), "1 entries"),
        ] {
            let error = strands.unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
    }
}
