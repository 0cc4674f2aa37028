//! Places labels beside the points of a plot, so that none covers another.

/// An upright rectangle in the units of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Rect {
    /// The square around a point.
    pub(super) fn around((x, y): (f64, f64), half: f64) -> Self {
        Self {
            left: x - half,
            top: y - half,
            right: x + half,
            bottom: y + half,
        }
    }

    /// True if they share more than an edge.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn holds(&self, other: &Self) -> bool {
        self.left <= other.left
            && other.right <= self.right
            && self.top <= other.top
            && other.bottom <= self.bottom
    }

    /// The point of it that is nearest to another.
    fn nearest(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (
            x.clamp(self.left, self.right),
            y.clamp(self.top, self.bottom),
        )
    }

    /// True if the segment enters it: a clip of the segment by the four sides.
    fn meets(&self, [a, b]: Segment) -> bool {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (from, along, low, high) in [
            (a.0, b.0 - a.0, self.left, self.right),
            (a.1, b.1 - a.1, self.top, self.bottom),
        ] {
            if along == 0.0 {
                if from <= low || high <= from {
                    return false;
                }
                continue;
            }
            let (t0, t1) = ((low - from) / along, (high - from) / along);
            enter = enter.max(t0.min(t1));
            leave = leave.min(t0.max(t1));
        }
        enter < leave
    }
}

/// Both ends of a straight line.
pub(super) type Segment = [(f64, f64); 2];

/// Where a label has found room.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placed {
    /// The rectangle that its text covers.
    pub(super) rect: Rect,
    /// A line from the point to the text, where they are far apart.
    pub(super) leader: Option<Segment>,
}

/// A label that wants room.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    pub(super) point: (f64, f64),
    pub(super) text: String,
    /// How far from the point it may be.
    pub(super) reach: f64,
}

/// The plot as labels see it.
#[derive(Debug, Clone)]
pub(super) struct Labels {
    /// Labels stay inside of this.
    area: Rect,
    /// Height of the letters, in units of the picture.
    size: f64,
    /// Rectangles that labels must not cover: markers and other labels.
    taken: Vec<Rect>,
    /// Lines that labels should not cover: curves.
    curves: Vec<Segment>,
    /// Lines to labels, which later labels must not cover.
    leaders: Vec<Segment>,
}

/// Distances from the point at which a label is tried.
const DISTANCES: [f64; 14] = [
    8.0, 13.0, 20.0, 29.0, 40.0, 54.0, 70.0, 90.0, 115.0, 145.0, 180.0, 220.0, 250.0, 280.0,
];

/// Directions that are tried at each of them, the first is to the right.
const DIRECTIONS: u32 = 24;

/// A label that is farther away than this gets a line to its point.
const ATTACHED: f64 = 15.0;

/// The cost of covering a curve, as a distance.
const COVERED: f64 = 14.0;

impl Labels {
    pub(super) fn new(area: Rect, size: f64) -> Self {
        Self {
            area,
            size,
            taken: Vec::new(),
            curves: Vec::new(),
            leaders: Vec::new(),
        }
    }

    /// Keeps labels off a marker.
    pub(super) fn keep_off(&mut self, marker: Rect) {
        self.taken.push(marker);
    }

    /// Makes labels avoid a curve, where there is room beside it.
    pub(super) fn avoid(&mut self, curve: Segment) {
        self.curves.push(curve);
    }

    /// Takes a place if it is free.
    pub(super) fn take(&mut self, rect: Rect) -> bool {
        let is_free =
            self.area.holds(&rect) && !self.taken.iter().any(|taken| taken.overlaps(&rect));
        if is_free {
            self.taken.push(rect);
        }
        is_free
    }

    /// Finds room for a text beside a point, no farther away than `reach`, and
    /// takes it: the nearest place that covers no marker, no label and no line to
    /// one, and as few curves as can be. `None` if there is no room.
    pub(super) fn place(&mut self, point: (f64, f64), text: &str, reach: f64) -> Option<Placed> {
        let (width, height) = (width(text, self.size), 1.25 * self.size);
        let mut best: Option<(f64, Placed)> = None;
        for distance in DISTANCES.into_iter().filter(|d| *d <= reach) {
            if best.is_some_and(|(cost, _)| cost <= distance) {
                break;
            }
            for step in 0..DIRECTIONS {
                let angle = std::f64::consts::TAU * f64::from(step) / f64::from(DIRECTIONS);
                let rect = beside(point, (angle.cos(), -angle.sin()), distance, width, height);
                let Some(placed) = self.fits(point, rect, distance) else {
                    continue;
                };
                let covered = self.curves.iter().filter(|curve| rect.meets(**curve));
                let cost = distance + COVERED * covered.count() as f64;
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, placed));
                }
            }
        }
        let (_, placed) = best?;
        self.taken.push(placed.rect);
        self.leaders.extend(placed.leader);
        Some(placed)
    }

    /// Finds room for as many of the texts as it can. The first text may take the room that
    /// another one needs, so a few orders are tried.
    pub(super) fn place_all(&mut self, wanted: &[Wanted]) -> Vec<Option<Placed>> {
        let forward: Vec<usize> = (0..wanted.len()).collect();
        let backward = forward.iter().rev().copied().collect();
        let every_other = |first: usize| {
            let even = forward.iter().filter(move |i| *i % 2 == first);
            let odd = forward.iter().filter(move |i| *i % 2 != first);
            even.chain(odd).copied().collect()
        };
        let inwards = {
            let mut order = forward.clone();
            order.sort_by_key(|i| (*i).min(wanted.len() - 1 - *i));
            order
        };
        let orders = [
            forward.clone(),
            backward,
            every_other(0),
            every_other(1),
            inwards,
        ];
        let mut best: Option<(usize, Self, Vec<Option<Placed>>)> = None;
        for order in orders {
            let mut tried = self.clone();
            let mut found = vec![None; wanted.len()];
            for index in order {
                let Wanted { point, text, reach } = &wanted[index];
                found[index] = tried.place(*point, text, *reach);
            }
            let count = found.iter().flatten().count();
            if best.as_ref().is_none_or(|(most, ..)| count > *most) {
                best = Some((count, tried, found));
            }
        }
        let Some((_, tried, found)) = best else {
            return Vec::new();
        };
        *self = tried;
        found
    }

    /// The label at that place, unless it covers something that it must not.
    fn fits(&self, point: (f64, f64), rect: Rect, distance: f64) -> Option<Placed> {
        if !self.area.holds(&rect)
            || self.taken.iter().any(|taken| taken.overlaps(&rect))
            || self.leaders.iter().any(|leader| rect.meets(*leader))
        {
            return None;
        }
        let leader = (distance > ATTACHED).then(|| [point, rect.nearest(point)]);
        if let Some(leader) = leader {
            let own = |taken: &&Rect| !taken.overlaps(&Rect::around(point, 0.5));
            if self.taken.iter().filter(own).any(|t| t.meets(leader)) {
                return None;
            }
        }
        Some(Placed { rect, leader })
    }
}

/// The rectangle of that size in a direction from a point; the gap between them is
/// `distance`.
fn beside(
    (x, y): (f64, f64),
    (dx, dy): (f64, f64),
    distance: f64,
    width: f64,
    height: f64,
) -> Rect {
    let centre = (
        x + dx * (distance + 0.5 * width),
        y + dy * (distance + 0.5 * height),
    );
    Rect {
        left: centre.0 - 0.5 * width,
        top: centre.1 - 0.5 * height,
        right: centre.0 + 0.5 * width,
        bottom: centre.1 + 0.5 * height,
    }
}

/// Where a text is held, so that it is near its point though shorter than its
/// rectangle.
pub(super) fn anchored(rect: Rect, (x, _): (f64, f64)) -> (f64, &'static str) {
    if rect.left >= x {
        (rect.left, "start")
    } else if rect.right <= x {
        (rect.right, "end")
    } else {
        (0.5 * (rect.left + rect.right), "middle")
    }
}

/// The largest width of a text, in bold letters too, in the fonts that browsers use for
/// interfaces, of which Verdana and DejaVu Sans are the widest.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let of = |letter: char| match letter {
        'i' | 'j' | 'l' | '.' | ',' | ':' | '\'' | '|' => 0.38,
        'f' | 't' | 'r' | 'I' | ' ' | '(' | ')' | '-' => 0.5,
        'm' | 'w' | 'M' | 'W' | '%' => 1.05,
        'A'..='Z' => 0.83,
        _ => 0.72,
    };
    text.chars().map(of).sum::<f64>() * size
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: Rect = Rect {
        left: 0.0,
        top: 0.0,
        right: 1000.0,
        bottom: 500.0,
    };

    #[test]
    fn labels_of_crowded_points_cover_neither_each_other_nor_markers() {
        for spread in [0.0, 1.0, 6.0, 25.0] {
            let mut labels = Labels::new(AREA, 15.0);
            let point = |i: u32| {
                let i = f64::from(i);
                (500.0 + spread * i, 250.0 + spread * (0.7 * i).sin())
            };
            let markers: Vec<Rect> = (0..14).map(|i| Rect::around(point(i), 6.0)).collect();
            for marker in &markers {
                labels.keep_off(*marker);
            }
            let wanted: Vec<Wanted> = (0..14)
                .map(|i| Wanted {
                    point: point(i),
                    text: "exact visibility, 2".into(),
                    reach: 280.0,
                })
                .collect();
            let placed: Vec<Placed> = labels.place_all(&wanted).into_iter().flatten().collect();
            // Labels of one and the same point soon shut each other in.
            let least = if spread < 6.0 { 4 } else { 10 };
            assert!(placed.len() >= least, "{spread}: {}", placed.len());
            for (index, one) in placed.iter().enumerate() {
                assert!(AREA.holds(&one.rect), "{one:?}");
                assert!(!markers.iter().any(|marker| marker.overlaps(&one.rect)));
                for other in &placed[..index] {
                    assert!(!one.rect.overlaps(&other.rect), "{one:?} {other:?}");
                    for (label, line) in [(one, other.leader), (other, one.leader)] {
                        assert!(line.is_none_or(|line| !label.rect.meets(line)));
                    }
                }
            }
        }
    }

    #[test]
    fn a_lonely_label_is_right_beside_its_point_and_off_its_curve() {
        let mut labels = Labels::new(AREA, 15.0);
        labels.avoid([(300.0, 200.0), (700.0, 200.0)]);
        let placed = labels.place((300.0, 200.0), "ray marching", 60.0).unwrap();
        assert_eq!(placed.leader, None);
        assert!(!placed.rect.meets([(300.0, 200.0), (700.0, 200.0)]));
        let near = placed.rect.nearest((300.0, 200.0));
        assert!((near.0 - 300.0).hypot(near.1 - 200.0) < 30.0, "{placed:?}");
    }

    #[test]
    fn where_there_is_no_room_there_is_no_label() {
        let mut labels = Labels::new(Rect::around((50.0, 50.0), 20.0), 15.0);
        assert_eq!(labels.place((50.0, 50.0), "too long for this", 220.0), None);
        let mut labels = Labels::new(AREA, 15.0);
        labels.keep_off(AREA);
        assert_eq!(labels.place((50.0, 50.0), "8", 220.0), None);
        assert_eq!(labels.place((f64::NAN, 50.0), "8", 220.0), None);
        assert_eq!(labels.place_all(&[]), []);
    }

    #[test]
    fn segments_meet_what_they_cross() {
        let rect = Rect::around((0.0, 0.0), 1.0);
        for (segment, meets) in [
            ([(-2.0, 0.0), (2.0, 0.0)], true),
            ([(-2.0, 1.0), (2.0, 1.0)], false),
            ([(-2.0, -2.0), (2.0, 2.0)], true),
            ([(0.0, 0.0), (0.1, 0.1)], true),
            ([(2.0, 0.0), (3.0, 0.0)], false),
            ([(-2.0, 0.5), (0.0, 3.0)], false),
        ] {
            assert_eq!(rect.meets(segment), meets, "{segment:?}");
        }
    }
}
