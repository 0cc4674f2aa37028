//! Depth maps that are hard in some way, and the voxels that they mean.

use proptest::prelude::*;

use crate::{DepthSource, Error, Exits, Resolution, TileRect};

/// The slices of every texel, in memory.
#[derive(Debug, Clone)]
pub(crate) struct Map {
    pub(crate) resolution: Resolution,
    pub(crate) enter: Vec<u32>,
    pub(crate) exit: Option<Vec<u32>>,
}

impl Map {
    /// A map of `side` texels whose slices `depths` gives by column and row.
    pub(crate) fn new(side: u32, depths: impl Fn(u32, u32) -> [u32; 2]) -> Self {
        let texels: Vec<[u32; 2]> = (0..side * side)
            .map(|i| depths(i % side, i / side))
            .collect();
        Self {
            resolution: Resolution::new(side).unwrap(),
            enter: texels.iter().map(|texel| texel[0]).collect(),
            exit: Some(texels.iter().map(|texel| texel[1]).collect()),
        }
    }

    /// The same surfaces without insides.
    pub(crate) fn open(self) -> Self {
        Self { exit: None, ..self }
    }

    pub(crate) fn side(&self) -> u32 {
        self.resolution.side()
    }

    /// The enter and exit slice of a texel, as the conventions define them.
    pub(crate) fn texel(&self, x: u32, y: u32) -> [u32; 2] {
        let at = (y * self.side() + x) as usize;
        let enter = self.enter[at].min(self.side());
        let exit = self
            .exit
            .as_ref()
            .map_or(enter, |exit| exit[at].clamp(enter, self.side()));
        [enter, exit]
    }

    /// Whether a voxel is lit; none if it may be either.
    pub(crate) fn defined(&self, x: u32, y: u32, z: u32) -> Option<bool> {
        let [enter, exit] = self.texel(x, y);
        if z < enter {
            Some(true)
        } else if z >= exit {
            Some(false)
        } else {
            None
        }
    }
}

impl DepthSource for Map {
    fn resolution(&self) -> Resolution {
        self.resolution
    }

    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error> {
        let (width, side) = (self.side() as usize, tile.side as usize);
        for row in 0..side {
            let from = (tile.y as usize + row) * width + tile.x as usize;
            enter[row * side..][..side].copy_from_slice(&self.enter[from..][..side]);
            if let Some(exits) = &self.exit {
                exit[row * side..][..side].copy_from_slice(&exits[from..][..side]);
            }
        }
        Ok(if self.exit.is_some() {
            Exits::Closed
        } else {
            Exits::Open
        })
    }
}

/// One of the named hard maps.
pub(crate) fn named(side: u32) -> Vec<(&'static str, Map)> {
    let n = side;
    vec![
        ("constant", Map::new(n, |_, _| [n / 3, n / 2])),
        ("all near", Map::new(n, |_, _| [0, 0])),
        ("all near, solid", Map::new(n, |_, _| [0, n])),
        ("all far", Map::new(n, |_, _| [n, n])),
        (
            "staircase",
            Map::new(n, |x, y| [(x + y) / 2, (x + y) / 2 + 3]),
        ),
        ("steep staircase", Map::new(n, |x, _| [x, x])),
        (
            "checkerboard",
            Map::new(n, |x, y| {
                let z = if (x + y) % 2 == 0 { 0 } else { n };
                [z, z]
            }),
        ),
        (
            "checkerboard of free insides",
            Map::new(n, |x, y| {
                if (x + y) % 2 == 0 {
                    [1, n / 2]
                } else {
                    [n / 2 - 1, n]
                }
            }),
        ),
        (
            "one texel",
            Map::new(n, |x, y| {
                if (x, y) == (n / 2, n / 3) {
                    [3, 4]
                } else {
                    [n, n]
                }
            }),
        ),
        (
            "one hole",
            Map::new(n, |x, y| {
                if (x, y) == (n - 1, 0) {
                    [n, n]
                } else {
                    [2, n - 1]
                }
            }),
        ),
        // What is in front of 5 changes inside of a volume, and again far
        // behind: reuse that looks only behind a node gets this wrong.
        (
            "changes inside and far behind",
            Map::new(n, |x, y| match (x % 4, y % 4) {
                (0, 0) => [5, 5],
                (1, 1) => [n - 1, n - 1],
                _ => [n, n],
            }),
        ),
    ]
}

/// A map of blocks of different sizes and depths over a floor, with noise of
/// single texels; closed or open.
pub(crate) fn arbitrary(side: u32) -> impl Strategy<Value = Map> {
    let block = (
        0..side,
        0..side,
        0..=side,
        0..=side,
        0..=side,
        0..=side,
        0..=1_u32,
    );
    (
        (0..=side, 0..=side),
        proptest::collection::vec(block, 0..12),
        any::<bool>(),
    )
        .prop_map(move |((floor, thickness), blocks, closed)| {
            let map = Map::new(side, |x, y| {
                let mut texel = [floor, floor + thickness];
                for &(x0, y0, width, height, enter, inside, single) in &blocks {
                    let size = if single == 1 { [0, 0] } else { [width, height] };
                    let hit = (x0..=x0 + size[0]).contains(&x) && (y0..=y0 + size[1]).contains(&y);
                    if hit {
                        texel = [enter, enter + inside];
                    }
                }
                texel
            });
            if closed { map } else { map.open() }
        })
}

/// A map without any order.
pub(crate) fn noise(side: u32) -> impl Strategy<Value = Map> {
    let texels = (side * side) as usize;
    let texel = (0..=side, prop_oneof![Just(0), 0..4_u32, 0..=side]);
    (proptest::collection::vec(texel, texels), any::<bool>()).prop_map(move |(texels, closed)| {
        let map = Map::new(side, |x, y| {
            let (enter, inside) = texels[(y * side + x) as usize];
            [enter, enter + inside]
        });
        if closed { map } else { map.open() }
    })
}
