//! Marching only in shadow, without the scene: times and errors of brute force, of the hybrid of
//! shadow volumes and marching, and of a textured light, on meshes as large as the paper's.
//!
//! Based on: Wyman and Ramsey, Interactive Volumetric Shadows in Participating Media with
//! Single-Scattering, RT 2008: its table 1, which has frame rates alone, and its figures 5
//! and 6, in numbers.

mod reductions;
mod steps;
mod table;
mod test_scene;

use lighting::methods::Registry;
use lighting::scene::procedural::StandIn;

use super::{Kind, Limit, Subject, record, value_columns};
use crate::compare::study::{Key, Study};
use crate::failure::Failure;
use crate::progress;
use test_scene::TestScene;

pub(super) const KIND: Kind = Kind {
    title: "marching only where shadow is",
    csv: "marching.csv",
    columns: value_columns,
    seconds: Some([1.0, 30.0]),
    in_fog: false,
    pointless,
    run,
};

/// Width and height of the pictures.
const SIZE: [u32; 2] = [480, 270];
const QUICK_SIZE: [u32; 2] = [64, 36];

/// A method as the paper's table has it.
#[derive(Debug, Clone, Copy)]
struct Variant {
    name: &'static str,
    /// The method of this program.
    method: &'static str,
    /// Its quality, in that table.
    steps: u32,
    /// Whether the light is the one with a cookie.
    textured: bool,
    key: Key,
}

const BRUTE: Variant = Variant {
    name: "brute force",
    method: "march-merged x gauss-8",
    steps: 150,
    textured: false,
    key: Key::new(0),
};
const HYBRID: Variant = Variant {
    name: "hybrid",
    method: "hybrid x gauss-8",
    steps: 50,
    textured: false,
    key: Key::new(1),
};
const TEXTURED_BRUTE: Variant = Variant {
    name: "brute force, textured",
    method: "march x midpoint",
    steps: 150,
    textured: true,
    key: Key::new(2),
};
/// Steps of colour across the beam; twice as many of shadow.
const TEXTURED: Variant = Variant {
    name: "textured",
    method: "textured x gauss-1",
    steps: 50,
    textured: true,
    key: Key::new(3),
};

/// One frame of a variant.
#[derive(Debug, Clone, Copy)]
struct Measured {
    /// Time of everything that depends on the light and the casters alone, and time of the frame.
    seconds: [f64; 2],
    rmse: f64,
    /// Share of the pixels that are gathered in full.
    in_full: f64,
}

/// A row of the paper's table.
struct PaperRow {
    /// The paper's mesh.
    name: &'static str,
    stand_in: StandIn,
    /// Frames per second on a GPU of 2008 by brute force, by the hybrid and with the textured
    /// light; each with light gathered at 1024² and at 256² pixels.
    rates: [[f64; 2]; 3],
}

const TABLE: [PaperRow; 7] = [
    PaperRow {
        name: "sphere",
        stand_in: StandIn::Ball,
        rates: [[12.9, 59.8], [85.0, 99.6], [45.5, 83.5]],
    },
    PaperRow {
        name: "elephant",
        stand_in: StandIn::Cluster,
        rates: [[12.6, 57.7], [89.6, 101.1], [33.5, 78.2]],
    },
    PaperRow {
        name: "spring",
        stand_in: StandIn::Spring,
        rates: [[14.6, 73.1], [76.8, 112.5], [18.0, 72.5]],
    },
    PaperRow {
        name: "bunny",
        stand_in: StandIn::Dented,
        rates: [[11.9, 61.6], [47.5, 87.5], [32.3, 81.3]],
    },
    PaperRow {
        name: "fairy",
        stand_in: StandIn::Crowd,
        rates: [[12.3, 63.5], [38.5, 72.1], [35.9, 78.3]],
    },
    PaperRow {
        name: "buddha",
        stand_in: StandIn::Stack,
        rates: [[12.2, 46.9], [50.2, 61.4], [28.3, 61.7]],
    },
    PaperRow {
        name: "yeah right",
        stand_in: StandIn::Tangle,
        rates: [[11.1, 32.8], [26.3, 33.8], [16.1, 40.9]],
    },
];

fn pointless(_: &Subject<'_>) -> Option<&'static str> {
    let registry = Registry::standard();
    [BRUTE, HYBRID, TEXTURED_BRUTE, TEXTURED]
        .iter()
        .any(|variant| registry.find(variant.method).is_none())
        .then_some("one of the methods that it compares is not in this build")
}

fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    let (size, shown) = match subject.quick {
        true => (QUICK_SIZE, &TABLE[..1]),
        false => (SIZE, &TABLE[..]),
    };
    let registry = Registry::standard();
    let bar = progress::bar("marching", shown.len() as u64 + 2);
    let mut rows = Vec::new();
    let mut ball = None;
    let mut last = 0.0;
    for of_paper in shown {
        // Each mesh has more triangles than the one before.
        if let Some(why) = limit.reached_after(2.0 * last) {
            study.leave_out("larger meshes", why);
            break;
        }
        let before = limit.elapsed();
        let scene = TestScene::new(of_paper.stand_in, size, subject.map)?;
        rows.push(table::row(&registry, of_paper, &scene)?);
        ball.get_or_insert(scene);
        last = limit.elapsed() - before;
        bar.inc(1);
    }
    if subject.quick {
        study.leave_out("larger meshes and other numbers of steps", "--quick");
    }
    table::describe(&mut study, &rows);
    let Some(ball) = ball else {
        bar.finish_and_clear();
        return Ok(study);
    };
    reductions::measure(&registry, &ball, (&mut study, limit))?;
    bar.inc(1);
    steps::measure(&registry, &ball, subject.quick, (&mut study, limit))?;
    bar.finish_and_clear();
    study.introduction = format!(
        "The scene plays no part here. Meshes like those of the paper stand in fog, with a lamp \
         and a spotlight with a cookie behind them. On the CPU, pictures of {} x {} pixels, \
         shadow maps of {}². Errors are RMSE of the airlight over its mean against ray-traced \
         visibility, on about 1500 of the pixels; times are the faster of two frames. {} is {}, \
         {} is {}, {} is {}, and {} is {}.",
        size[0],
        size[1],
        subject.map,
        BRUTE.name,
        BRUTE.method,
        HYBRID.name,
        HYBRID.method,
        TEXTURED_BRUTE.name,
        TEXTURED_BRUTE.method,
        TEXTURED.name,
        TEXTURED.method,
    );
    Ok(study)
}

#[cfg(test)]
mod tests {
    use lighting::scene::procedural::Embedded;

    use super::*;
    use crate::compare::studies::tests::Stand;
    use crate::compare::study::{Part, Value};

    /// Nothing is left out without a word, whatever the time.
    #[test]
    fn a_quick_study_has_every_part_and_one_without_time_says_so() {
        let stand = Stand::of(Embedded::City);
        let subject = stand.subject();
        let study = run(&subject, &Limit::of(f64::INFINITY)).unwrap();
        assert!(study.left_out.len() == 1 && !study.introduction.is_empty());
        let shown = |is: fn(&Part) -> bool| study.parts.iter().filter(|part| is(part)).count();
        assert_eq!(shown(|part| matches!(part, Part::Table(_))), 3);
        assert_eq!(shown(|part| matches!(part, Part::Charts(_))), 2);
        for row in study.records.rows() {
            assert!(matches!(row.cells[3].value, Value::Number(value) if value >= 0.0));
        }
        let none = run(&subject, &Limit::of(0.0)).unwrap();
        assert!(none.records.rows().is_empty() && none.left_out.len() == 2);
    }
}
