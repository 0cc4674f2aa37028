//! A march in the picture of every light.

use crate::Touching;
use crate::methods::march::Marches;
use crate::methods::registry::pairs;
use crate::methods::{Compared, Entry, Role};
use crate::visibility::Spacing;

pub(in crate::methods) fn methods() -> Vec<Entry> {
    pairs!(
        Marches {
            name: "light-space",
            title: "marching in the map",
            spacing: Spacing::Picture,
            touching: Touching::Apart,
        },
        &[Compared {
            airlight: "gauss",
            detail: Some(1),
            title: "marching in the map",
            purpose: "beams of spotlights, seen along them or from near: steps as dense as texels",
            paper: "Gautron, Marvie and François, Volumetric Shadow Mapping, SIGGRAPH 2009 Talks",
            qualities: (&[4, 16, 64, 256, 1024], &[16, 64], 64),
            role: Role::Paper,
            is_baseline: false,
        }]
    )
}
