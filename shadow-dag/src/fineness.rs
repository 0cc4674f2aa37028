//! How fine a grid has to be for what its light shines on.

use glam::DVec3;
use gpu_backend::Cpu;

use crate::depths::{DepthSource, TileRect};
use crate::{Error, LightSpace, Mesh, Resolution, Slices, Surfaces};

/// Voxels along each axis of the grid in which lit surfaces are looked for: slices
/// of a lamp are then a few hundredths of its distance high.
const LOOK: u32 = 256;

impl Surfaces<'_> {
    /// The least resolution, up to `most`, at which nine in ten of the texels that show a
    /// surface are at most `texel` metres wide on it, in the grids of one light together.
    /// Across its rays: on a surface that they graze a texel is longer.
    ///
    /// Lit surfaces are looked for in grids of 256 voxels along each axis, so distances
    /// from a lamp are known to a slice. Grids that show nothing take the least
    /// resolution, 8.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless `texel` is a finite length above 0.
    pub fn fineness(
        &self,
        cpu: &Cpu,
        spaces: &[LightSpace],
        texel: f64,
        most: Resolution,
    ) -> Result<Resolution, Error> {
        if !(texel > 0.0 && texel < f64::INFINITY) {
            let expected = "a finite length above 0";
            return Err(Error::bad_value("the width of a texel", texel, expected));
        }
        let look = Resolution::new(LOOK)?;
        let tile = TileRect {
            x: 0,
            y: 0,
            side: LOOK,
        };
        let (mut enter, mut exit) = (vec![0; tile.len()], vec![0; tile.len()]);
        // Of maps, on the surface that a texel shows.
        let mut widths = Vec::new();
        for space in spaces {
            Mesh::of(cpu, self, *space, look).read(tile, &mut enter, &mut exit)?;
            // A step of `s` metres across the rays moves a point of the map by `s` times
            // the length of the row, for a lamp of what is across its axis and over W.
            let [x, y, w] = [0, 1, 3].map(|row| space.matrix().row(row).truncate());
            let across = |row: DVec3| match space.slices() {
                Slices::Linear => row.length().recip(),
                Slices::Logarithmic(_) => (row - row.project_onto(w)).length().recip(),
            };
            let width = across(x).max(across(y));
            let seen = enter.iter().filter(|&&slice| slice < LOOK);
            widths.extend(seen.map(|&slice| match space.slices() {
                Slices::Linear => width,
                slices => width * slices.depth((f64::from(slice) + 0.5) / f64::from(LOOK)),
            }));
        }
        let most_of_them = widths.len() * 9 / 10;
        let texels = if widths.is_empty() {
            0.0
        } else {
            *widths
                .select_nth_unstable_by(most_of_them, f64::total_cmp)
                .1
                / texel
        };
        let coarser = (0..most.log2()).filter_map(Resolution::from_log2);
        let mut enough = coarser.filter(|resolution| f64::from(resolution.side()) >= texels);
        Ok(enough.next().unwrap_or(most))
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat4;

    use super::*;

    /// A square of side 8 at `z = -distance`.
    fn wall(distance: f32) -> Surfaces<'static> {
        let corners = [[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]];
        let corners = corners.map(|[x, y]| [x, y, -distance]);
        Surfaces::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    fn fineness(distance: f32, space: LightSpace, texel: f64) -> u32 {
        let most = Resolution::new(1 << 14).unwrap();
        let found = wall(distance).fineness(&Cpu::new(), &[space], texel, most);
        found.unwrap().side()
    }

    #[test]
    fn a_texel_is_as_wide_as_asked_for_where_the_light_shines() {
        let right_angle = std::f64::consts::FRAC_PI_2;
        let lamp = LightSpace::perspective(DMat4::IDENTITY, right_angle, 0.1, 20.0).unwrap();
        let sun = LightSpace::orthographic(DMat4::IDENTITY, 6.0, 4.0, 0.0, 20.0).unwrap();
        // The map is 4 m wide at 2 m, and 16 m at 8 m.
        assert_eq!(fineness(2.0, lamp, 4.0 / 400.0), 512);
        assert_eq!(fineness(2.0, lamp, 4.0 / 900.0), 1024);
        assert_eq!(fineness(8.0, lamp, 4.0 / 400.0), 2048);
        for distance in [2.0, 8.0] {
            assert_eq!(fineness(distance, sun, 6.0 / 500.0), 512);
            assert_eq!(fineness(distance, sun, 6.0 / 530.0), 1024);
        }
        assert_eq!(fineness(2.0, lamp, 1e-9), 1 << 14);
        assert_eq!(fineness(2.0, lamp, 1e9), 8);
        // Nothing is lit behind the last slice.
        assert_eq!(fineness(30.0, lamp, 0.01), 8);
    }

    #[test]
    fn a_width_that_is_none_is_an_error() {
        let sun = LightSpace::orthographic(DMat4::IDENTITY, 6.0, 4.0, 0.0, 20.0).unwrap();
        let most = Resolution::new(64).unwrap();
        for texel in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let found = wall(1.0).fineness(&Cpu::new(), &[sun], texel, most);
            assert!(matches!(found, Err(Error::BadValue { .. })));
        }
    }
}
