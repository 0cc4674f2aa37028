//! What can go wrong.

use epipolar::Resolution;

/// Why a step or a query could not be carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Things that belong together have different numbers of voxels.
    #[error("{what} has the resolution {actual:?}, expected {expected:?}")]
    Resolution {
        /// What does not fit.
        what: &'static str,
        /// The resolution that it should have.
        expected: Resolution,
        /// The resolution that it has.
        actual: Resolution,
    },
    /// A number outside of its range.
    #[error("{what} is {value}, expected {expected}")]
    BadValue {
        /// Which number.
        what: &'static str,
        /// As it was given.
        value: f64,
        /// What would have been right.
        expected: &'static str,
    },
    /// A grid or a map that the backend cannot hold, or bind.
    #[error(
        "{what} of {} voxels takes {requested} bytes, but the limit is {limit} bytes{}",
        shown(*.resolution),
        .fits.map_or(String::new(), |fits| format!(": {} voxels would fit", shown(fits)))
    )]
    TooLarge {
        /// What does not fit.
        what: &'static str,
        /// Its voxels.
        resolution: Resolution,
        /// Bytes asked for.
        requested: u64,
        /// The largest number of bytes that would have been accepted.
        limit: u64,
        /// The next smaller resolution of that shape that would fit, if there is one.
        fits: Option<Resolution>,
    },
    /// An atlas that the backend cannot hold, or bind.
    #[error(
        "{what} of {tiles} tiles of {} voxels is too large: {fit} would fit",
        shown(*.resolution)
    )]
    TooManyTiles {
        /// What does not fit.
        what: &'static str,
        /// Voxels of a tile.
        resolution: Resolution,
        /// Tiles asked for.
        tiles: usize,
        /// Tiles that would have been accepted.
        fit: u64,
    },
    /// An atlas has too few tiles.
    #[error("an atlas of {tiles} tiles was given, expected at least {needed}")]
    Tile {
        /// How many it should have.
        needed: usize,
        /// How many it has.
        tiles: usize,
    },
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
}

/// α × θ × φ.
fn shown(resolution: Resolution) -> String {
    let (alpha, theta, bits) = (resolution.alpha(), resolution.theta(), resolution.bits());
    format!("{alpha} × {theta} × {bits}")
}

/// Turns a backend's error about a buffer into one about `what`, which has `elements` numbers of
/// four bytes.
pub(crate) fn too_large(
    what: &'static str,
    resolution: Resolution,
    elements: fn(&Resolution) -> usize,
) -> impl Fn(gpu_backend::Error) -> Error {
    move |error| match error {
        gpu_backend::Error::TooLarge {
            requested, limit, ..
        } => Error::TooLarge {
            what,
            resolution,
            requested,
            limit,
            fits: smaller(resolution, |r| 4 * elements(r) as u64 <= limit),
        },
        other => Error::Backend(other),
    }
}

/// The same of so many tiles.
pub(crate) fn too_many_tiles(
    what: &'static str,
    resolution: Resolution,
    tiles: usize,
    elements: usize,
) -> impl Fn(gpu_backend::Error) -> Error {
    move |error| match error {
        gpu_backend::Error::TooLarge { limit, .. } => Error::TooManyTiles {
            what,
            resolution,
            tiles,
            fit: limit / (4 * elements as u64),
        },
        other => Error::Backend(other),
    }
}

/// The largest number of voxels is halved until they fit.
fn smaller(resolution: Resolution, fits: impl Fn(&Resolution) -> bool) -> Option<Resolution> {
    let mut sides = [resolution.alpha(), resolution.theta(), resolution.bits()];
    loop {
        let largest = (0..3).max_by_key(|&side| {
            let can_be_halved = side < 2 || sides[2].is_multiple_of(64);
            if can_be_halved { sides[side] } else { 0 }
        })?;
        sides[largest] /= 2;
        let [alpha, theta, bits] = sides;
        let resolution = Resolution::new(alpha, theta, bits).ok()?;
        if fits(&resolution) {
            return Some(resolution);
        }
    }
}

pub(crate) fn same_resolution(
    what: &'static str,
    expected: Resolution,
    actual: Resolution,
) -> Result<(), Error> {
    if expected == actual {
        return Ok(());
    }
    Err(Error::Resolution {
        what,
        expected,
        actual,
    })
}

pub(crate) fn same_length(what: &'static str, expected: usize, actual: usize) -> Result<(), Error> {
    if expected == actual {
        return Ok(());
    }
    Err(Error::Backend(gpu_backend::Error::LengthMismatch {
        what,
        expected,
        actual,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_is_named_with_what_would_fit() {
        let resolution = Resolution::new(1024, 1024, 96).unwrap();
        let refused = |limit| gpu_backend::Error::TooLarge {
            what: "a buffer",
            requested: 4 * resolution.words() as u64,
            limit,
        };
        let name = too_large("a bit grid", resolution, Resolution::words);
        assert_eq!(
            name(refused(4 << 20)).to_string(),
            "a bit grid of 1024 × 1024 × 96 voxels takes 12582912 bytes, but the limit is \
             4194304 bytes: 512 × 512 × 96 voxels would fit"
        );
        assert!(!name(refused(3)).to_string().contains("would fit"));
        let name = too_many_tiles("an atlas", resolution, 7, resolution.words());
        assert_eq!(
            name(refused(30 << 20)).to_string(),
            "an atlas of 7 tiles of 1024 × 1024 × 96 voxels is too large: 2 would fit"
        );
    }
}
