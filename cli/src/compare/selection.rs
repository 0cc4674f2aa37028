//! Which methods and qualities are compared, and why the others are not.

use lighting::methods::{Entry, FrameInputs, Method, Registry, Role, Verdict};
use lighting::plan::{Plan, Subject};

use super::prepare::Asked;
use super::results::LeftOut;
use super::schedule::Place;
use super::shown::{self, Shown};
use crate::failure::Failure;
use crate::suggest::unknown_method;

/// One method at one quality.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    /// Place of the method among those that comparisons show.
    pub(crate) method: usize,
    pub(crate) entry: Entry,
    /// Its name in the report.
    pub(crate) title: String,
    pub(crate) quality: u32,
    /// Texels per side of the shadow maps that it may look into.
    pub(crate) map: u32,
    /// Whether it looks into any.
    uses_maps: bool,
    /// Its maps are finer where its quality is higher.
    pub(crate) refines_map: bool,
    is_end: bool,
}

impl Candidate {
    /// The method's title with its quality.
    pub(crate) fn name(&self) -> String {
        let unit = self.entry.about().quality;
        format!("{}, {} {unit}", self.title, self.quality)
    }

    /// Texels per side of the shadow maps that it does look into.
    pub(crate) fn map_in_use(&self) -> Option<u32> {
        self.uses_maps.then_some(self.map)
    }

    /// The facts on which its turn depends.
    pub(crate) fn place(&self) -> Place {
        Place {
            role: match self.refines_map {
                true => Role::Variant,
                false => self.entry.about().role,
            },
            is_end: self.is_end,
        }
    }
}

/// The candidates that will run, in the order of the registry, and all that will not.
#[derive(Debug, Clone, Default)]
pub(crate) struct Selection {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) left_out: Vec<LeftOut>,
}

/// Returns an error if a name of `--methods` names no method.
pub(crate) fn check_names(methods: &Registry, filters: &[String]) -> Result<(), Failure> {
    for filter in filters {
        if !methods.compared().any(|entry| entry.matches(filter)) {
            return Err(unknown_method(methods, filter));
        }
    }
    Ok(())
}

fn title_and_name(shown: &Shown) -> String {
    format!("{} ({})", shown.title, shown.entry.about().name)
}

/// One line with the reason for every name of `--methods` of which nothing is
/// left to run.
pub(crate) fn dropped(
    methods: &Registry,
    filters: &[String],
    selection: &Selection,
) -> Vec<String> {
    let mut lines = Vec::new();
    for filter in filters {
        if selection.candidates.iter().any(|c| c.entry.matches(filter)) {
            continue;
        }
        let all = shown::all(methods);
        let mut named = all.iter().filter(|shown| shown.entry.matches(filter));
        let part = named.find_map(|shown| {
            let what = title_and_name(shown);
            selection.left_out.iter().find(|part| part.what == what)
        });
        if let Some(part) = part {
            lines.push(format!("--methods {filter} is left out, {}", part.why));
        }
    }
    lines
}

/// Why a method is left out of pictures in which smoke is seen, or is not.
fn out_of_place(sees_media: bool, entry: &Entry, inputs: &FrameInputs<'_>) -> Option<String> {
    let why = match (sees_media, entry.sees_heterogeneous_media()) {
        (true, false) => {
            "it sees even fog alone, and the medium is not the same everywhere; its shadows are \
             compared with --smoke-unseen"
        }
        (false, true) if !inputs.media().is_homogeneous() => {
            "smoke and uneven fog are not seen here (--smoke-unseen)"
        }
        _ => return None,
    };
    Some(why.into())
}

/// Chooses from the registry by the options and the plan of the scene; without
/// `inputs` there is no airlight. `sees_media` tells whether smoke and uneven fog are
/// part of the pictures.
pub(crate) fn select(
    methods: &Registry,
    args: &Asked<'_>,
    plan: &Plan,
    inputs: Option<&FrameInputs<'_>>,
    sees_media: bool,
) -> Selection {
    let mut selection = Selection::default();
    for part in plan.left_out() {
        let what = match part.subject {
            // Methods are compared with all that they do.
            Subject::Shadows(_) => format!("{}, by `render`", part.subject),
            _ => part.subject.to_string(),
        };
        selection.left_out.push(LeftOut {
            what,
            why: part.why(),
        });
    }
    let no_airlight = || {
        let mut parts = plan.left_out().iter();
        let part = parts.find(|part| part.subject == Subject::Airlight);
        part.map_or("no light reaches the view".into(), |part| {
            part.reason.to_string()
        })
    };
    for (index, shown) in shown::all(methods).into_iter().enumerate() {
        let entry = &shown.entry;
        let asked = args.methods.is_empty() || args.methods.iter().any(|f| entry.matches(f));
        let why = if !asked {
            Some("not asked for (--methods)".into())
        } else if shown.refines_map && args.quick {
            Some("a quick comparison (--quick)".into())
        } else if let Some(inputs) = inputs {
            out_of_place(sees_media, entry, inputs).or_else(|| {
                match entry.method().applies(inputs) {
                    Verdict::Applies => None,
                    Verdict::Pointless(why) | Verdict::Impossible(why) => Some(why.into_owned()),
                }
            })
        } else {
            Some(no_airlight())
        };
        let (None, Some(inputs)) = (&why, inputs) else {
            selection.left_out.push(LeftOut {
                what: title_and_name(&shown),
                why: why.unwrap_or_else(no_airlight),
            });
            continue;
        };
        let about = entry.about();
        let all = if args.quick {
            about.quick
        } else {
            about.qualities
        };
        let (qualities, same) = entry.method().distinct(inputs, all);
        if let Some(why) = same {
            selection.left_out.push(LeftOut {
                what: format!("{} with other {}", shown.title, about.quality),
                why: why.into(),
            });
        }
        let last = qualities.len().saturating_sub(1);
        let candidates = qualities
            .iter()
            .enumerate()
            .map(|(place, quality)| Candidate {
                method: index,
                entry: entry.clone(),
                title: shown.title.clone(),
                quality: *quality,
                map: shown.map(*quality, inputs),
                uses_maps: entry.uses_maps_of(inputs.geometry),
                refines_map: shown.refines_map,
                is_end: place == 0 || place == last,
            });
        selection.candidates.extend(candidates);
    }
    if args.quick && !selection.candidates.is_empty() {
        selection.left_out.push(LeftOut {
            what: "the other qualities".into(),
            why: "a quick comparison (--quick)".into(),
        });
    }
    selection
}
