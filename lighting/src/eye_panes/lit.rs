//! What is seen of a light whose shadows on rays are known, as a list that shaders read.

use gpu_backend::{Cpu, Error};

use super::{EyePanes, seen_along};
use crate::gather::RAYS;
use crate::scene::Medium;
use crate::visibility::{VisibilitySource, join_touching};
use crate::{Emitter, LightPath, Ray};

/// Rays that are asked about before memory is looked at.
const ROUND: usize = 1024 * RAYS;

impl EyePanes {
    /// What is seen of the light of one lamp that is scattered along rays with these `panes` in
    /// front, if `visibility` tells which parts of them are lit.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if it takes more than `most` bytes, as soon as that is known.
    pub(crate) fn lit<V: VisibilitySource>(
        cpu: &Cpu,
        panes: Option<&Self>,
        (rays, emitter): (&[Ray], &Emitter),
        visibility: &V,
        most: u64,
    ) -> Result<Self, Error> {
        let order = visibility.neighbours(rays, emitter);
        // Memory holds no more rays than a u32 counts.
        let order = order.unwrap_or_else(|| (0..rays.len() as u32).collect());
        let of_bundle = |numbers: &[u32]| {
            let paths = numbers.iter().filter_map(|ray| {
                let path = LightPath::new(&rays[*ray as usize], emitter, &Medium::VACUUM)?;
                Some(path.with_index(*ray).off_the_light())
            });
            let paths: Vec<LightPath<'_>> = paths.collect();
            let mut found = Vec::with_capacity(paths.len());
            visibility.lit_of_neighbours(&paths, &mut |path, parts| {
                join_touching(parts, 0);
                let ray = paths[path].index();
                let mut seen = Vec::with_capacity(2 * parts.len() + 1);
                seen_along(panes.map_or(&[], |panes| panes.of(ray)), parts, &mut seen);
                found.push((ray, seen));
            });
            found
        };
        let mut found = Vec::new();
        let mut of_rays = vec![0..0; rays.len()];
        for round in order.chunks(ROUND) {
            let bundles: Vec<&[u32]> = round.chunks(RAYS).collect();
            let bundles = cpu.map(bundles.len(), |bundle| of_bundle(bundles[bundle]));
            for (ray, seen) in bundles.into_iter().flatten() {
                let start = found.len();
                found.extend(seen);
                of_rays[ray as usize] = start..found.len();
            }
            let requested = size_of_val(&found[..]) as u64;
            if requested > most || found.len() > u32::MAX as usize {
                return Err(Error::TooLarge {
                    what: "the list of lit parts",
                    requested,
                    limit: most,
                });
            }
        }
        let mut all = Self::default();
        for own in of_rays {
            all.panes.extend_from_slice(&found[own]);
            all.ends.push(all.panes.len() as u32);
        }
        Ok(all)
    }
}
