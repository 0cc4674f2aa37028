//! What a film shows: tables, strips, files.

use reference::film::{FilmError, Lag, film_error, lag};

use super::frames::Frames;
use super::path::{Moved, Shot, Steps};
use super::strip::{apng, beside};
use super::take::Take;
use super::{CSV, Filmed, Write};
use crate::compare::files::slug;
use crate::compare::study::{Cell, Column, Key, Part, Strip, Study, Table, Unit};
use crate::compare::times::Times;
use crate::failure::Failure;
use crate::format::{count, significant};
use crate::parse::Size;
use crate::picture::Picture;

/// Full colour in pictures of differences, as a share of the mean radiance.
const FULL: f64 = 0.1;

/// Frames of a strip, at most, and the sides of each of its two pictures: a page holds the
/// strips of all methods.
const MOST_FRAMES: usize = 24;
const MOST_SIDES: [u32; 2] = [160, 90];

/// A method in a shot.
pub(super) struct Shown {
    key: Option<Key>,
    name: String,
    title: String,
    unit: &'static str,
    quality: u32,
    error: FilmError,
    lag: Option<Lag>,
    seconds: Times,
    made: usize,
    reused: usize,
    strip: Option<Strip>,
}

impl Shown {
    /// Measures a film, and makes a strip of it where frames follow each other.
    pub(super) fn new(
        filmed: &Filmed,
        take: Take,
        frames: &Frames,
        shot: &Shot,
    ) -> Result<Self, Failure> {
        let about = filmed.entry.about();
        let is_continuous = shot.steps == Steps::Small;
        let error = film_error(&take.pictures, &frames.references);
        let strip = match is_continuous {
            true => {
                let name = format!("{}, {} {}", filmed.title, filmed.quality, about.quality);
                Some(strip(name, &take, frames, &error)?)
            }
            false => None,
        };
        Ok(Self {
            key: filmed.slot.map(Key::new),
            name: about.name.into_owned(),
            title: filmed.title.clone(),
            unit: about.quality,
            quality: filmed.quality,
            lag: is_continuous
                .then(|| lag(&take.pictures, &frames.references))
                .flatten(),
            error,
            seconds: take.seconds,
            made: take.made,
            reused: take.reused,
            strip,
        })
    }
}

/// By how much the sides of a picture are divided for a strip.
fn reduction(size: Size) -> u32 {
    let [width, height] = MOST_SIDES;
    (size.width.div_ceil(width)).max(size.height.div_ceil(height))
}

/// The picture and its difference to the reference, frame by frame, no larger than
/// [`MOST_SIDES`].
fn strip(name: String, take: &Take, frames: &Frames, error: &FilmError) -> Result<Strip, Failure> {
    let side = reduction(frames.size);
    let unit = if error.absolute { 1.0 } else { error.mean };
    let scale = (FULL * unit) as f32;
    let frame = |(picture, truth): (&Vec<[f32; 4]>, &reference::metrics::Reference)| {
        let picture = Picture::new(frames.size, picture).averaged(side);
        let truth = Picture::of_reference(frames.size, &truth.radiance).averaged(side);
        let tones = picture.tones(frames.exposure);
        let differences = picture.differences(&truth, scale);
        (
            picture.size,
            beside(picture.size.width, &tones, &differences),
        )
    };
    let all = take.pictures.iter().zip(&frames.references);
    let (sizes, all): (Vec<Size>, Vec<Vec<u8>>) = all.take(MOST_FRAMES).map(frame).unzip();
    let size = Size {
        width: 2 * sizes[0].width,
        height: sizes[0].height,
    };
    let file = apng(size, &all)?;
    Ok(Strip { name, size, file })
}

/// Columns of the records; later versions add to the end.
pub(super) fn columns() -> Vec<Column> {
    let names = [
        "moved",
        "steps",
        "step_metres",
        "method",
        "title",
        "backend",
        "quality",
        "quality_unit",
        "frames",
        "mean_radiance",
        "error_rmse",
        "error_change",
        "change_ratio",
        "lag_frames",
        "lag_share",
        "seconds_frame",
        "things_made",
        "things_reused",
    ];
    names.map(Column::plain).into()
}

/// Adds a shot to the records and to the parts that are shown.
pub(super) fn add(
    study: &mut Study,
    shot: &Shot,
    frames: &Frames,
    backend: &str,
    takes: Vec<Shown>,
) {
    if takes.is_empty() {
        return;
    }
    let or_empty = |value: Option<f64>| value.map_or_else(|| Cell::from(""), Cell::from);
    let unit = match takes[0].error.absolute {
        true => Unit::Number,
        false => Unit::Share,
    };
    let is_continuous = shot.steps == Steps::Small;
    let mut columns = vec![
        Column::plain("method"),
        Column::new("RMSE", unit),
        Column::new("frame to frame", unit),
        Column::plain("ratio"),
    ];
    if is_continuous {
        columns.push(Column::new("lag", Unit::With("frames")));
        columns.push(Column::new("due to lag", Unit::Share));
    }
    columns.push(Column::new("frame", Unit::Seconds));
    columns.extend(["made", "used again"].map(|name| Column {
        soft: true,
        ..Column::plain(name)
    }));
    let mut table = Table::new(columns).titled(capitalised(&shot.name()), caption(shot));
    for shown in &takes {
        let ratio = shown.error.ratio();
        study.records.push(vec![
            shot.moved.name().into(),
            shot.steps.name().into(),
            or_empty(shot.length.map(f64::from)),
            shown.name.as_str().into(),
            shown.title.as_str().into(),
            backend.into(),
            shown.quality.into(),
            shown.unit.into(),
            frames.all.len().into(),
            shown.error.mean.into(),
            shown.error.rmse.into(),
            shown.error.change.into(),
            ratio.into(),
            or_empty(shown.lag.map(|lag| lag.frames)),
            or_empty(shown.lag.map(|lag| lag.share)),
            shown.seconds.median.into(),
            shown.made.into(),
            shown.reused.into(),
        ]);
        let title = format!("{}, {}", shown.title, shown.quality);
        let mut cells = vec![
            match shown.key {
                Some(key) => Cell::keyed(title, key),
                None => title.into(),
            },
            shown.error.rmse.into(),
            shown.error.change.into(),
            ratio.into(),
        ];
        if is_continuous {
            let of_lag = |value: fn(&Lag) -> f64| match &shown.lag {
                Some(lag) => value(lag).into(),
                None => Cell::from("–"),
            };
            cells.push(of_lag(|lag| lag.frames));
            cells.push(of_lag(|lag| lag.share));
        }
        cells.push(shown.seconds.median.into());
        cells.push(shown.made.into());
        cells.push(shown.reused.into());
        table.push(cells);
    }
    study.parts.push(Part::Table(table));
    let strips: Vec<Strip> = takes.into_iter().filter_map(|shown| shown.strip).collect();
    if !strips.is_empty() {
        study.parts.push(Part::Strips(strips));
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn caption(shot: &Shot) -> String {
    let Some(length) = shot.length else {
        return match shot.steps {
            Steps::Small => format!(
                "Turned by {} rad from frame to frame, to and fro by the same directions: half a \
                 texel of a shadow map that spans a right angle. An error that stays on the scene \
                 has a ratio below 1.",
                significant(f64::from(shot.angle))
            ),
            Steps::Large => format!(
                "Turned by up to {} rad, to directions that have nothing to do with each other. \
                 Errors that have nothing to do with each other either have the ratio √2 = 1.41.",
                significant(f64::from(shot.angle))
            ),
        };
    };
    let length = significant(f64::from(length));
    match (shot.steps, shot.moved) {
        (Steps::Small, Moved::Camera) => format!(
            "{length} m from frame to frame, forth and back by the same places: a third of a pixel at the \
             mean distance of what is seen. An error that stays on the scene has a ratio below 1."
        ),
        (Steps::Small, Moved::Lights) => format!(
            "{length} m from frame to frame, forth and back by the same places: at the mean \
             distance half a texel of a shadow map that spans a right angle; suns turn by as much. An \
             error that stays on the scene has a ratio below 1."
        ),
        (Steps::Large, _) => format!(
            "To places up to {length} m away that have nothing to do with each other, and turned by up to \
             0.1 rad. Errors that have nothing to do with each other either have the ratio √2 = 1.41."
        ),
    }
}

pub(super) fn introduction(frames: usize, size: Size, backend: &str) -> String {
    format!(
        "{} of {size} in each shot, on {backend}; every method at the quality of its picture. RMSE: root of \
         the mean squared error of all frames. Frame to frame: the same of what the error changes by \
         from each frame to the next, which is seen as flicker. Both are divided by the mean \
         radiance of the reference film; the ratio is the second over the first. Lag: the shift in \
         frames with which a film fits its reference best, where the past fits it better than the \
         future, and the share of the squared error that is gone with it.",
        count(frames, "frame")
    )
}

/// The notes below the shots.
pub(super) fn notes(has_files: bool) -> Vec<Part> {
    let mut notes = vec![Part::Note(format!(
        "Strips show the picture beside its signed difference to the reference: blue is too dark, orange too \
         bright, full colour {} % of the mean radiance or more; the ramp is a square root. Made and \
         used again: how many maps, voxels, tables and the like a method made for its frames, and \
         how often it took one that was there.",
        100.0 * FULL
    ))];
    if has_files {
        notes.push(Part::Note(
            "The frames are beside this page as film-*.png; see `crepuscular compare --help` for \
             how ColorVideoVDP compares them."
                .into(),
        ));
    }
    notes
}

/// Writes the frames of a method, or of the reference, as PNG files.
pub(super) fn write(
    frames: &Frames,
    shot: &Shot,
    of: Option<(&Filmed, &Take)>,
    write: Write<'_>,
) -> Result<(), Failure> {
    let name = match of {
        Some((filmed, _)) => format!("{}-{}", slug(&filmed.entry.about().name), filmed.quality),
        None => "reference".into(),
    };
    let pictures = (0..frames.all.len()).map(|index| match of {
        Some((_, take)) => Picture::new(frames.size, &take.pictures[index]),
        None => Picture::of_reference(frames.size, &frames.references[index].radiance),
    });
    let (moved, steps) = (shot.moved.name(), shot.steps.name());
    for (index, picture) in pictures.enumerate() {
        let name = format!("film-{moved}-{steps}-{name}-{index:04}.png");
        write(&name, &picture.png(frames.exposure)?)?;
    }
    Ok(())
}

/// Whether a report may have a file of that name.
pub(crate) fn is_ours(name: &str) -> bool {
    let is_frame = || {
        let name = name.strip_prefix("film-")?.strip_suffix(".png")?;
        let (name, index) = name.rsplit_once('-')?;
        let mut words = name.splitn(3, '-');
        let moved = [Moved::Camera, Moved::Lights].map(Moved::name);
        let steps = [Steps::Small, Steps::Large].map(Steps::name);
        let is_it = moved.contains(&words.next()?)
            && steps.contains(&words.next()?)
            && words
                .next()
                .is_some_and(|of| of == slug(of) && !of.is_empty())
            && index.len() == 4
            && index.bytes().all(|digit| digit.is_ascii_digit());
        is_it.then_some(())
    };
    name == CSV || is_frame().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_are_no_larger_than_a_page_can_hold() {
        for (width, height) in [
            (160, 90),
            (161, 90),
            (480, 270),
            (1000, 7),
            (1, 3000),
            (3, 3),
        ] {
            let size = Size { width, height };
            let side = reduction(size);
            let small = Picture::black(size).averaged(side).size;
            assert!(small.width <= MOST_SIDES[0] && small.height <= MOST_SIDES[1]);
            assert!(small.width >= 1 && small.height >= 1);
            assert_eq!(side == 1, width <= 160 && height <= 90);
        }
    }
}
