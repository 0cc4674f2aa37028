//! The one list of methods: which parts of a ray see the light × how much
//! light arrives from a part.

use clap::ValueEnum;
use lighting::voxels::Detail;

/// A source of lit intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Visibility {
    /// Nothing is in the way: no volumetric shadows
    None,
    /// Interval ends computed from the triangles that block the ray
    Exact,
    /// Steps of equal length through a shadow map
    March,
    /// The same, runs of lit steps joined to one interval
    MarchMerged,
    /// Steps of equal angle as seen from the light
    EquiAngular,
    /// The same, runs of lit steps joined to one interval
    EquiAngularMerged,
    /// Voxelized shadow volumes: the share of a ray's voxels that are lit, for all of it
    VoxelAverage,
    /// Voxelized shadow volumes: each lit voxel by itself
    VoxelBits,
    /// Voxelized shadow volumes: runs of lit voxels
    VoxelRuns,
    /// Baked shadows: a walk through compact precomputed voxels
    Dag,
    /// Steps through a map of transmittance: what hair and smoke let through
    Translucent,
}

impl Visibility {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Exact => "exact",
            Self::March => "march",
            Self::MarchMerged => "march-merged",
            Self::EquiAngular => "equi-angular",
            Self::EquiAngularMerged => "equi-angular-merged",
            Self::VoxelAverage => "voxel-average",
            Self::VoxelBits => "voxel-bits",
            Self::VoxelRuns => "voxel-runs",
            Self::Dag => "dag",
            Self::Translucent => "translucent",
        }
    }

    /// True if it looks into a shadow map.
    pub(crate) fn needs_shadow_map(self) -> bool {
        !matches!(
            self,
            Self::None | Self::Exact | Self::Dag | Self::Translucent
        )
    }

    /// True if it is found by tracing, which only the CPU does.
    pub(crate) fn is_traced(self) -> bool {
        self == Self::Exact
    }

    /// True if its steps are equal angles as seen from a point light.
    pub(crate) fn is_equi_angular(self) -> bool {
        matches!(self, Self::EquiAngular | Self::EquiAngularMerged)
    }

    /// What it reads from voxels, if it does.
    pub(crate) fn voxel_detail(self) -> Option<Detail> {
        match self {
            Self::VoxelAverage => Some(Detail::Average),
            Self::VoxelBits => Some(Detail::Voxels),
            Self::VoxelRuns => Some(Detail::Runs),
            _ => None,
        }
    }

    /// True if it marches.
    pub(crate) fn has_steps(self) -> bool {
        self == Self::Translucent || self.needs_shadow_map() && self.voxel_detail().is_none()
    }
}

/// An evaluator of a lit interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Airlight {
    /// Gauss-Legendre quadrature by scale, with as many nodes as a tolerance needs
    Quadrature,
    /// A table of 64 KiB for lights at points; the quadrature for all others
    Table,
    /// Gauss-Legendre quadrature with a number of nodes, equi-angular at a point light
    #[value(name = "gauss")]
    EquiAngular,
    /// One sample in the middle
    Midpoint,
    /// In double precision; goes with exact visibility
    Double,
    /// The table of Sun et al. as published; isotropic media, exact visibility
    Published,
}

impl Airlight {
    /// True if it is for lights that shine alike in all directions.
    pub(crate) fn is_for_points(self) -> bool {
        matches!(self, Self::Table | Self::Double | Self::Published)
    }
}

/// A pair with its numbers fixed: what a picture is made with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Setting {
    pub(crate) visibility: Visibility,
    /// Steps per ray of a march, voxels along each coordinate or axis.
    pub(crate) samples: u32,
    pub(crate) airlight: Airlight,
    /// The evaluator's number: nodes per lit interval of an equi-angular
    /// quadrature, decimal digits of a tolerance, KiB of a table.
    pub(crate) detail: u32,
}

/// What a method's quality is a number of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quality {
    /// Steps of the march or voxels along each coordinate; the evaluator has this
    /// number.
    Samples { detail: u32 },
    /// The evaluator's number.
    Detail,
}

/// A method of the comparison.
#[derive(Debug)]
pub(crate) struct Method {
    pub(crate) visibility: Visibility,
    pub(crate) airlight: Airlight,
    pub(crate) quality: Quality,
    /// Every quality that is compared, in rising order.
    pub(crate) qualities: &'static [u32],
    /// Those of a quick comparison.
    pub(crate) quick: &'static [u32],
    /// The one whose picture is shown.
    pub(crate) pictured: u32,
    /// What it is, in a few words.
    pub(crate) title: &'static str,
    /// What it is for.
    pub(crate) purpose: &'static str,
    /// Who described it.
    pub(crate) paper: &'static str,
}

const STEPS: &[u32] = &[4, 8, 16, 32, 64, 128, 256];
const QUICK_STEPS: &[u32] = &[8, 32, 128];
const VOXELS: &[u32] = &[64, 128, 256, 512, 1024];
const QUICK_VOXELS: &[u32] = &[64, 256];
const GRIDS: &[u32] = &[256, 512, 1024, 2048, 4096, 8192];
const QUICK_GRIDS: &[u32] = &[512, 2048];

/// All methods, in the order of reports.
pub(crate) static METHODS: &[Method] = &[
    Method {
        visibility: Visibility::None,
        airlight: Airlight::EquiAngular,
        quality: Quality::Detail,
        qualities: &[8],
        quick: &[8],
        pictured: 8,
        title: "no shadows",
        purpose: "what leaving the shadows out would cost; the floor of the run time",
        paper: "Sun et al., A Practical Analytic Single Scattering Model, SIGGRAPH 2005 (the integral)",
    },
    Method {
        visibility: Visibility::Exact,
        airlight: Airlight::EquiAngular,
        quality: Quality::Detail,
        qualities: &[2, 4, 8, 16],
        quick: &[2, 8],
        pictured: 8,
        title: "exact intervals",
        purpose: "truth at the price of tracing; sharp shafts from thin blockers",
        paper: "the shadow-volume half of Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008",
    },
    Method {
        visibility: Visibility::Exact,
        airlight: Airlight::Quadrature,
        quality: Quality::Detail,
        qualities: &[2, 3, 4, 5],
        quick: &[4],
        pictured: 4,
        title: "exact, to a tolerance",
        purpose: "any light and any phase function to as many digits as asked for",
        paper: "the integral of Sun et al., SIGGRAPH 2005, in a half-angle variable",
    },
    Method {
        visibility: Visibility::Exact,
        airlight: Airlight::Table,
        quality: Quality::Detail,
        qualities: &[16, 64],
        quick: &[64],
        pictured: 64,
        title: "exact, by table",
        purpose: "point lights: two lookups for a lit run, wherever the light is",
        paper: "Sun et al., SIGGRAPH 2005, with a table of the scaled tail instead of theirs",
    },
    Method {
        visibility: Visibility::Exact,
        airlight: Airlight::Published,
        quality: Quality::Detail,
        qualities: &[512],
        quick: &[512],
        pictured: 512,
        title: "exact, by the published table",
        purpose: "what the table of 2005 costs in error: dense fog, looks away from the light",
        paper: "Sun et al., A Practical Analytic Single Scattering Model, SIGGRAPH 2005",
    },
    Method {
        visibility: Visibility::Exact,
        airlight: Airlight::Double,
        quality: Quality::Detail,
        qualities: &[64],
        quick: &[64],
        pictured: 64,
        title: "exact, in double precision",
        purpose: "point lights to all digits; the rest of the error is that of positions in f32",
        paper: "Sun et al., SIGGRAPH 2005, by the scaled exponential integral",
    },
    Method {
        visibility: Visibility::March,
        airlight: Airlight::Midpoint,
        quality: Quality::Samples { detail: 1 },
        qualities: STEPS,
        quick: QUICK_STEPS,
        pictured: 32,
        title: "ray marching",
        purpose: "the classical baseline: any light, any medium, least code",
        paper: "folklore; as the comparison in Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013",
    },
    Method {
        visibility: Visibility::MarchMerged,
        airlight: Airlight::EquiAngular,
        quality: Quality::Samples { detail: 8 },
        qualities: STEPS,
        quick: QUICK_STEPS,
        pictured: 32,
        title: "marched visibility",
        purpose: "as ray marching, but the light of a lit run does not depend on the steps",
        paper: "Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008 (march between shadow bounds)",
    },
    Method {
        visibility: Visibility::EquiAngular,
        airlight: Airlight::EquiAngular,
        quality: Quality::Samples { detail: 1 },
        qualities: STEPS,
        quick: QUICK_STEPS,
        pictured: 32,
        title: "equi-angular sampling",
        purpose: "point lights in view: steps gather where the inverse square is large",
        paper: "Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in Participating Media, EGSR 2012",
    },
    Method {
        visibility: Visibility::EquiAngularMerged,
        airlight: Airlight::EquiAngular,
        quality: Quality::Samples { detail: 8 },
        qualities: STEPS,
        quick: QUICK_STEPS,
        pictured: 32,
        title: "equi-angular visibility",
        purpose: "point lights in view, with runs of lit steps integrated as one",
        paper: "Kulla and Fajardo, EGSR 2012, for the steps; Sun et al., SIGGRAPH 2005, for the integral",
    },
    Method {
        visibility: Visibility::EquiAngularMerged,
        airlight: Airlight::Table,
        quality: Quality::Samples { detail: 64 },
        qualities: STEPS,
        quick: QUICK_STEPS,
        pictured: 32,
        title: "equi-angular visibility by table",
        purpose: "point lights in view, with two lookups for a run of lit steps",
        paper: "Kulla and Fajardo, EGSR 2012, for the steps; Sun et al., SIGGRAPH 2005, for the integral",
    },
    Method {
        visibility: Visibility::VoxelAverage,
        airlight: Airlight::EquiAngular,
        quality: Quality::Samples { detail: 8 },
        qualities: VOXELS,
        quick: QUICK_VOXELS,
        pictured: 256,
        title: "voxelized shadow volumes, average",
        purpose: "least work per ray, at any number of blockers; its error has a floor",
        paper: "Wyman, Voxelized Shadow Volumes, HPG 2011; the gather of Wyman and Dai, HPG 2013",
    },
    Method {
        visibility: Visibility::VoxelBits,
        airlight: Airlight::EquiAngular,
        quality: Quality::Samples { detail: 1 },
        qualities: VOXELS,
        quick: QUICK_VOXELS,
        pictured: 256,
        title: "voxelized shadow volumes, bit by bit",
        purpose: "the same bits with a weight each: no floor but that of the shadow map",
        paper: "Wyman, Voxelized Shadow Volumes, HPG 2011",
    },
    Method {
        visibility: Visibility::VoxelRuns,
        airlight: Airlight::EquiAngular,
        quality: Quality::Samples { detail: 8 },
        qualities: VOXELS,
        quick: QUICK_VOXELS,
        pictured: 256,
        title: "voxelized shadow volumes, run by run",
        purpose: "the same bits by runs: any light, as few evaluations as can be",
        paper: "Wyman, Voxelized Shadow Volumes, HPG 2011, for the bits",
    },
    Method {
        visibility: Visibility::VoxelRuns,
        airlight: Airlight::Table,
        quality: Quality::Samples { detail: 64 },
        qualities: VOXELS,
        quick: QUICK_VOXELS,
        pictured: 256,
        title: "voxelized shadow volumes by table",
        purpose: "point lights: one texel for the visibility of a ray, two lookups for a run",
        paper: "Wyman, HPG 2011, for the bits; Sun et al., SIGGRAPH 2005, for the integral",
    },
    Method {
        visibility: Visibility::Dag,
        airlight: Airlight::EquiAngular,
        quality: Quality::Samples { detail: 8 },
        qualities: GRIDS,
        quick: QUICK_GRIDS,
        pictured: 2048,
        title: "baked shadows",
        purpose: "static scenes: baked once, walked in large steps, fine enough for any view",
        paper: "Sintorn et al., Compact Precomputed Voxelized Shadows, SIGGRAPH 2014; Kämpe et al., I3D 2015",
    },
    Method {
        visibility: Visibility::Dag,
        airlight: Airlight::Table,
        quality: Quality::Samples { detail: 64 },
        qualities: GRIDS,
        quick: QUICK_GRIDS,
        pictured: 2048,
        title: "baked shadows by table",
        purpose: "point lights in static scenes: two lookups for a lit run",
        paper: "Sintorn et al., SIGGRAPH 2014; Kämpe et al., I3D 2015; Sun et al., SIGGRAPH 2005, for the integral",
    },
    Method {
        visibility: Visibility::Translucent,
        airlight: Airlight::EquiAngular,
        quality: Quality::Samples { detail: 1 },
        qualities: STEPS,
        quick: QUICK_STEPS,
        pictured: 32,
        title: "adaptive volumetric shadow map",
        purpose: "hair and smoke: a curve of 8 nodes per texel tells how much gets how far",
        paper: "Salvi et al., Adaptive Volumetric Shadow Maps, EGSR 2010; nodes by least area instead of theirs",
    },
];

impl Method {
    /// The evaluator's name, with its number where that is fixed.
    pub(crate) fn airlight_name(&self) -> String {
        let name = match self.airlight {
            Airlight::Quadrature => "quadrature",
            Airlight::Table => "table",
            Airlight::EquiAngular => "gauss",
            Airlight::Midpoint => return "midpoint".into(),
            Airlight::Double => "double",
            Airlight::Published => "published",
        };
        match self.quality {
            Quality::Detail => name.into(),
            Quality::Samples { detail } => format!("{name}-{detail}"),
        }
    }

    /// Its place in [`METHODS`].
    pub(crate) fn place(&self) -> usize {
        let place = METHODS.iter().position(|method| std::ptr::eq(method, self));
        place.expect("every method is one of the list")
    }

    /// The pair that it is: `march x midpoint`.
    pub(crate) fn name(&self) -> String {
        format!("{} x {}", self.visibility.name(), self.airlight_name())
    }

    /// What its quality counts.
    pub(crate) fn quality_name(&self) -> &'static str {
        match self.quality {
            Quality::Samples { .. } if self.visibility.has_steps() => "steps",
            Quality::Samples { .. } => "voxels a side",
            Quality::Detail => match self.airlight {
                Airlight::Quadrature => "digits",
                Airlight::Table => "KiB",
                Airlight::Published => "entries a side",
                Airlight::Double => "bits",
                Airlight::EquiAngular | Airlight::Midpoint => "nodes",
            },
        }
    }

    /// The method at one quality.
    pub(crate) fn at(&self, quality: u32) -> Setting {
        let (samples, detail) = match self.quality {
            Quality::Samples { detail } => (quality, detail),
            Quality::Detail => (0, quality),
        };
        Setting {
            visibility: self.visibility,
            samples,
            airlight: self.airlight,
            detail,
        }
    }

    /// True if `filter` names it: its pair, its visibility or its title, or a
    /// part of these.
    pub(crate) fn matches(&self, filter: &str) -> bool {
        let filter = filter.trim().to_lowercase().replace('×', "x");
        !filter.is_empty()
            && (self.visibility.name() == filter
                || self.name().contains(&filter)
                || self.title.contains(&filter))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_distinct_and_qualities_rise() {
        for (index, method) in METHODS.iter().enumerate() {
            assert!(METHODS[..index].iter().all(|m| m.name() != method.name()));
            assert!(METHODS[..index].iter().all(|m| m.title != method.title));
            assert!(method.qualities.is_sorted());
            for list in [method.quick, &[method.pictured]] {
                assert!(list.iter().all(|q| method.qualities.contains(q)));
            }
        }
    }

    #[test]
    fn filters_find_methods_by_any_of_their_names() {
        let found = |filter: &str| METHODS.iter().filter(|m| m.matches(filter)).count();
        assert_eq!(found("march x midpoint"), 1);
        assert_eq!(found("march × midpoint"), 1, "as `methods` prints it");
        assert_eq!(found("exact"), 5);
        assert_eq!(found("Equi-Angular visibility"), 2);
        assert_eq!(found("published"), 1);
        assert_eq!(found("no such thing"), 0);
        assert_eq!(found(""), 0);
    }
}
