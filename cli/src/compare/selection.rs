//! Which methods and qualities are compared, and why the others are not.

use lighting::plan::{Plan, Reason, Subject};

use super::results::LeftOut;
use crate::args::Compare;
use crate::engine::PUBLISHED_IS_ISOTROPIC;
use crate::failure::Failure;
use crate::methods::{Airlight, METHODS, Method, Quality, Setting, Visibility};

/// One method at one quality.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) method: &'static Method,
    pub(crate) quality: u32,
}

impl Candidate {
    pub(crate) fn setting(&self) -> Setting {
        self.method.at(self.quality)
    }

    /// The method's title with its quality.
    pub(crate) fn name(&self) -> String {
        format!(
            "{} with {} {}",
            self.method.title,
            self.quality,
            self.method.quality_name()
        )
    }
}

/// What will run, in the order of the registry, and what will not.
#[derive(Debug, Clone, Default)]
pub(crate) struct Selection {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) left_out: Vec<LeftOut>,
}

/// Makes sure that every name of `--methods` names something.
pub(crate) fn check_names(filters: &[String]) -> Result<(), Failure> {
    for filter in filters {
        if !METHODS.iter().any(|method| method.matches(filter)) {
            let names: Vec<String> = METHODS.iter().map(Method::name).collect();
            return Err(Failure::new(format!(
                "no method is called \"{filter}\"; there are {}",
                names.join(", ")
            )));
        }
    }
    Ok(())
}

fn title_and_name(method: &Method) -> String {
    format!("{} ({})", method.title, method.name())
}

/// One line with the reason for every name of `--methods` of which nothing is
/// left to run.
pub(crate) fn dropped(filters: &[String], selection: &Selection) -> Vec<String> {
    let mut lines = Vec::new();
    for filter in filters {
        if selection
            .candidates
            .iter()
            .any(|c| c.method.matches(filter))
        {
            continue;
        }
        let mut methods = METHODS.iter().filter(|method| method.matches(filter));
        let part = methods.find_map(|method| {
            let what = title_and_name(method);
            selection.left_out.iter().find(|part| part.what == what)
        });
        if let Some(part) = part {
            lines.push(format!("--methods {filter} is left out, {}", part.why));
        }
    }
    lines
}

/// What evaluators of airlight depend on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evaluated {
    /// A light shines alike in all directions from a point.
    pub(crate) has_even_points: bool,
    /// The medium scatters alike in all directions.
    pub(crate) is_isotropic: bool,
    /// There is hair or smoke.
    pub(crate) is_translucent: bool,
}

/// Methods of opaque casters say nothing about a scene with others; the first
/// of the exact ones stays, to show what their shadows are worth.
fn ignores_hair_and_smoke(method: &Method) -> bool {
    match method.visibility {
        Visibility::None | Visibility::Translucent => false,
        Visibility::Exact => method.airlight != Airlight::EquiAngular,
        _ => true,
    }
}

/// Chooses from the registry by the options and the plan of the scene.
pub(crate) fn select(args: &Compare, plan: &Plan, scene: Evaluated) -> Selection {
    let mut selection = Selection::default();
    for part in plan.left_out() {
        selection.left_out.push(LeftOut {
            what: part.subject.to_string(),
            why: part.reason.to_string(),
        });
    }
    let reason_for = |subject: &Subject| -> Option<Reason> {
        let mut parts = plan.left_out().iter();
        parts
            .find(|part| part.subject == *subject)
            .map(|part| part.reason)
    };
    let no_airlight = if plan.emitters().is_empty() {
        Some(
            reason_for(&Subject::Airlight)
                .map_or("no light reaches the view".into(), |r| r.to_string()),
        )
    } else {
        None
    };
    let no_angle = reason_for(&Subject::EquiAngularSteps).map(|reason| reason.to_string());
    for method in METHODS {
        let asked = args.methods.is_empty() || args.methods.iter().any(|f| method.matches(f));
        let why = if !asked {
            Some("not asked for (--methods)".into())
        } else if no_airlight.is_some() {
            no_airlight.clone()
        } else if method.visibility == Visibility::Translucent && !scene.is_translucent {
            Some("nothing in the scene is translucent".into())
        } else if scene.is_translucent && ignores_hair_and_smoke(method) {
            Some(
                "it does not see hair and smoke, which exact intervals and no shadows stand for"
                    .into(),
            )
        } else if method.visibility.is_equi_angular() && no_angle.is_some() {
            no_angle.clone()
        } else if method.airlight.is_for_points() && !scene.has_even_points {
            Some("no light shines alike in all directions from a point".into())
        } else if method.airlight == Airlight::Published && !scene.is_isotropic {
            Some(PUBLISHED_IS_ISOTROPIC.into())
        } else if method.airlight == Airlight::Quadrature && no_angle.is_some() {
            Some("the airlight of a directional light is in closed form".into())
        } else {
            None
        };
        if let Some(why) = why {
            selection.left_out.push(LeftOut {
                what: title_and_name(method),
                why,
            });
            continue;
        }
        let mut qualities = if args.quick {
            method.quick
        } else {
            method.qualities
        };
        if method.quality == Quality::Detail && no_angle.is_some() && qualities.len() > 1 {
            // Nodes are nodes of nothing.
            selection.left_out.push(LeftOut {
                what: format!("{} with other numbers of nodes", method.title),
                why: "the airlight of a directional light is in closed form".into(),
            });
            qualities = &qualities[..1];
        }
        selection.candidates.extend(
            qualities
                .iter()
                .map(|&quality| Candidate { method, quality }),
        );
    }
    if args.quick && !selection.candidates.is_empty() {
        selection.left_out.push(LeftOut {
            what: "the other qualities".into(),
            why: "a quick comparison (--quick)".into(),
        });
    }
    selection
}
