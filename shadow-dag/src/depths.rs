//! Where the shadow casters begin and end under every texel.

use crate::error::same_length;
use crate::{Error, LightSpace, Resolution, Slices};

/// A square of texels whose depths are asked for at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileRect {
    /// First column, a multiple of `side`.
    pub x: u32,
    /// First row, a multiple of `side`.
    pub y: u32,
    /// Columns and rows, a power of two of at least 8.
    pub side: u32,
}

impl TileRect {
    /// Texels in the tile.
    pub fn len(&self) -> usize {
        (self.side as usize) * (self.side as usize)
    }

    /// Never: a tile has texels.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// # Errors
    /// [`Error::BadValue`] if it is no tile of a map of `resolution`.
    pub(crate) fn check(&self, resolution: Resolution) -> Result<(), Error> {
        let side = self.side;
        if !(side.is_power_of_two() && (8..=resolution.side()).contains(&side)) {
            return Err(Error::bad_value(
                "the side of a tile",
                side,
                "a power of two from 8 to the resolution",
            ));
        }
        for at in [self.x, self.y] {
            if at % side != 0 || at >= resolution.side() {
                return Err(Error::bad_value(
                    "a corner of a tile",
                    at,
                    "a multiple of its side, on the map",
                ));
            }
        }
        Ok(())
    }

    /// # Errors
    /// [`Error::Length`] unless there are as many places as texels, and those
    /// of [`TileRect::check`].
    pub(crate) fn check_places(
        &self,
        resolution: Resolution,
        places: [&[u32]; 2],
    ) -> Result<(), Error> {
        self.check(resolution)?;
        for places in places {
            same_length("places for the texels of a tile", self.len(), places.len())?;
        }
        Ok(())
    }
}

/// What a source says about the exits of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exits {
    /// Everything behind the first surface is to be right: there are none.
    Open,
    /// They have been written.
    Closed,
}

/// A source of depths, as slices of the grid.
///
/// Under a texel, a voxel of slice `z` is lit if `z < enter` and shadowed if
/// `z ≥ exit`; in between it is inside of a solid and free. [`Slices`] turns
/// depths into slices by the rule that all parts of this crate share.
pub trait DepthSource: Sync {
    /// Voxels along each axis.
    fn resolution(&self) -> Resolution;

    /// Where in the grid a point of the world is, if the source knows; the
    /// shadows keep it.
    fn light(&self) -> Option<LightSpace> {
        None
    }

    /// Writes the slices of the texels of a tile, row by row: into `enter`,
    /// and into `exit` if [`Exits::Closed`] is returned. Values above the
    /// resolution count as the resolution, exits below `enter` as `enter`.
    ///
    /// May be called in any order and from several threads at once.
    ///
    /// # Errors
    /// Whatever keeps the source from knowing; building stops.
    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error>;
}

/// A map in memory of depths from 0 at the near to 1 at the far plane, or of
/// distances along the axis of the light if the slices are logarithmic.
#[derive(Debug, Clone, Copy)]
pub struct DepthMap<'a> {
    resolution: Resolution,
    slices: Slices,
    enter: &'a [f32],
    exit: Option<&'a [f32]>,
    light: Option<LightSpace>,
}

impl<'a> DepthMap<'a> {
    /// A map of `resolution²` depths, row by row. +∞ or anything beyond the
    /// far plane is nothing at all.
    ///
    /// # Errors
    /// [`Error::Length`] if there are not as many depths as texels.
    pub fn new(resolution: Resolution, slices: Slices, enter: &'a [f32]) -> Result<Self, Error> {
        let map = Self {
            resolution,
            slices,
            enter,
            exit: None,
            light: None,
        };
        map.check("enter depths", enter)?;
        Ok(map)
    }

    /// The same map for closed geometry: `exit` is where the ray of a texel
    /// first leaves the union of all solids again.
    ///
    /// # Errors
    /// [`Error::Length`] if there are not as many depths as texels.
    pub fn with_exit(mut self, exit: &'a [f32]) -> Result<Self, Error> {
        self.check("exit depths", exit)?;
        self.exit = Some(exit);
        Ok(self)
    }

    /// The same map with the space of the light that saw it, whose slices it
    /// takes.
    #[must_use]
    pub fn with_light(self, light: LightSpace) -> Self {
        Self {
            slices: *light.slices(),
            light: Some(light),
            ..self
        }
    }

    fn check(&self, what: &'static str, depths: &[f32]) -> Result<(), Error> {
        same_length(what, (self.resolution.side() as usize).pow(2), depths.len())
    }

    fn convert(
        &self,
        map: &'static str,
        depths: &[f32],
        tile: TileRect,
        out: &mut [u32],
    ) -> Result<(), Error> {
        let (width, side) = (self.resolution.side() as usize, tile.side as usize);
        let start = tile.y as usize * width + tile.x as usize;
        let rows = depths[start..].chunks(width).zip(out.chunks_mut(side));
        for (y, (depths, out)) in rows.enumerate() {
            let depths = &depths[..side];
            if let Some(x) = depths.iter().position(|depth| depth.is_nan()) {
                return Err(Error::NotANumber {
                    map,
                    x: tile.x + x as u32,
                    y: tile.y + y as u32,
                });
            }
            self.slices.boundaries(self.resolution, depths, out);
        }
        Ok(())
    }
}

impl DepthSource for DepthMap<'_> {
    fn resolution(&self) -> Resolution {
        self.resolution
    }

    fn light(&self) -> Option<LightSpace> {
        self.light
    }

    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error> {
        tile.check_places(self.resolution, [enter, exit])?;
        self.convert("enter", self.enter, tile, enter)?;
        match self.exit {
            None => Ok(Exits::Open),
            Some(depths) => self
                .convert("exit", depths, tile, exit)
                .map(|()| Exits::Closed),
        }
    }
}
