//! Plans as text.

use std::fmt;

use super::{LeftOut, Pass, Plan, Reason, Saving, Subject};

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for pass in &self.passes {
            writeln!(f, "runs: {pass}")?;
        }
        for part in &self.left_out {
            writeln!(f, "left out: {} ({})", part.subject, part.why())?;
        }
        Ok(())
    }
}

impl LeftOut {
    /// The reason and the saving, in words.
    pub fn why(&self) -> String {
        match self.saving {
            Saving::NOTHING => self.reason.to_string(),
            saving => format!("{}; saves {saving}", self.reason),
        }
    }
}

impl fmt::Display for Saving {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.rays, "ray"),
            (self.texels, "texel"),
            (self.bytes, "byte"),
        ];
        let counts = counts.iter().filter(|(count, _)| *count > 0);
        let texts: Vec<String> = counts
            .map(|(count, what)| match count {
                1 => format!("1 {what}"),
                _ => format!("{count} {what}s"),
            })
            .collect();
        f.write_str(&texts.join(", "))
    }
}

impl fmt::Display for Pass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, emitters) = match self {
            Self::Airlight { emitters } => ("airlight of", emitters),
            Self::Unshadowed { emitters } => ("in closed form, airlight of", emitters),
            Self::ShadowMaps { emitters } => ("if marched or voxelized, shadow map of", emitters),
            Self::Bakes { emitters } => {
                ("if precomputed, once for all frames, shadows of", emitters)
            }
            Self::DynamicMaps { emitters } => (
                "if precomputed, whenever it moves, shadow map of what is dynamic for",
                emitters,
            ),
            Self::EquiAngularSteps { emitters } => {
                ("if asked for, equi-angular steps at", emitters)
            }
        };
        write!(f, "{what} {}", list(emitters))
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Airlight => f.write_str("airlight"),
            Self::Emitters(emitters) => write!(f, "airlight of {}", list(emitters)),
            Self::Shadows(emitters) => write!(f, "shadows in the air of {}", list(emitters)),
            Self::DynamicMaps(emitters) => {
                write!(f, "shadow map of what is dynamic for {}", list(emitters))
            }
            Self::EquiAngularSteps => f.write_str("equi-angular steps"),
            Self::LightLists => f.write_str("lists of the lights of each tile"),
            Self::Atlas => f.write_str("an atlas of the points of area lights"),
            Self::Cookies => f.write_str("colours of cookies"),
            Self::Curves => f.write_str("curves of transmittance"),
            Self::Panes => f.write_str("what covers the air behind it"),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoMedium => "no medium",
            Self::NothingScattered => "the medium scatters nothing",
            Self::NoLight => "no light",
            Self::Dark => "no intensity",
            Self::NeverMeetsTheView => "range and cone never meet the view inside the medium",
            Self::NothingInTheWay => "no caster is between the light and the air of the view",
            Self::NothingMoves => "nothing is dynamic",
            Self::ReachesNothingDynamic => "the light shines on nothing that is dynamic",
            Self::FewBoundedLights => "fewer than eight lights have a range or a cone",
            Self::NoArea => "no light has an area",
            Self::NoCookie => "no light has a cookie",
            Self::NothingCoversTheAir => "neither hair nor a see-through surface is before the air",
            Self::NothingTranslucent => "nothing in the scene is translucent",
            Self::OnlyDirectionalLight => "a directional light has no equi-angular variable",
        })
    }
}

/// `emitter 3`, `emitters 0 to 4, 7`.
pub(super) fn list(indices: &[usize]) -> String {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for &index in indices {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == index => *last = index,
            _ => runs.push((index, index)),
        }
    }
    let texts: Vec<String> = runs
        .iter()
        .map(|&(first, last)| match last - first {
            0 => first.to_string(),
            1 => format!("{first}, {last}"),
            _ => format!("{first} to {last}"),
        })
        .collect();
    let plural = if indices.len() == 1 { "" } else { "s" };
    format!("emitter{plural} {}", texts.join(", "))
}
