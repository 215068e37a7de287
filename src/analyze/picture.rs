//! Maps of a flow as SVG: colours for the speed, arrows for the direction, outlines of bodies.

use std::fmt::Write;

/// Longest side of the map in pixels.
const SIDE: f64 = 640.0;
/// Pixels left, right, above and below the map.
const MARGIN: [f64; 4] = [70.0, 130.0, 50.0, 60.0];
/// Shades of the colours.
const SHADES: usize = 24;
/// Arrows along the longer side at most.
const ARROWS: usize = 26;
/// From slow to fast: light to a blue on which a dark arrow is still seen (after ColorBrewer's Blues).
const COLOURS: [[f64; 3]; 5] =
    [[247.0, 251.0, 255.0], [204.0, 223.0, 241.0], [148.0, 196.0, 223.0], [74.0, 152.0, 201.0], [33.0, 113.0, 181.0]];

/// A rectangular map: cells of one size, x to the right and y upwards.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Map {
    /// Caption.
    pub title: String,
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// What the colours mean, with its unit.
    pub colour: String,
    /// Left, right, lower and upper end.
    pub ends: [f64; 4],
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Flow along x and y in every cell, x fastest; `None` where nothing is known.
    pub flow: Vec<Option<[f64; 2]>>,
    /// Bodies: their centre, and their semi-axes along x and y.
    pub outlines: Vec<[f64; 4]>,
}

impl Map {
    /// The map as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        let [left, right, low, high] = self.ends;
        let scale = SIDE / (right - left).max(high - low);
        let [w, h] = [(right - left) * scale, (high - low) * scale];
        let (width, height) = (w + MARGIN[0] + MARGIN[1], h + MARGIN[2] + MARGIN[3]);
        let mut svg = format!(
            "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width:.0} {height:.0}' font-family='sans-serif' font-size='13'>\n\
             <rect width='100%' height='100%' fill='#fff'/>\n<text x='{:.0}' y='28' font-size='20' text-anchor='middle'>{}</text>\n",
            MARGIN[0] + w / 2.0,
            escaped(&self.title)
        );
        let _ = writeln!(svg, "<g transform='translate({} {})'>", MARGIN[0], MARGIN[2]);
        let _ = writeln!(
            svg,
            "<clipPath id='map'><rect width='{w:.1}' height='{h:.1}'/></clipPath><g clip-path='url(#map)'>"
        );
        let fastest = self.fastest();
        self.paint(&mut svg, [w, h], fastest);
        self.arrows(&mut svg, [w, h], fastest);
        for [x, y, rx, ry] in &self.outlines {
            let (cx, cy) = ((x - left) * scale, (high - y) * scale);
            let _ = writeln!(
                svg,
                "<ellipse cx='{cx:.1}' cy='{cy:.1}' rx='{:.1}' ry='{:.1}' fill='#e07a3f' stroke='#7c3a12' stroke-width='2'/>",
                rx * scale,
                ry * scale
            );
        }
        let _ = writeln!(svg, "</g><rect width='{w:.1}' height='{h:.1}' fill='none' stroke='#333'/>");
        self.axes(&mut svg, [w, h], scale);
        self.bar(&mut svg, [w, h], fastest);
        svg += "</g></svg>\n";
        svg
    }

    fn fastest(&self) -> f64 {
        self.flow.iter().flatten().map(|[u, v]| u.hypot(*v)).fold(1e-300, f64::max)
    }

    /// One path for every shade, with a rectangle for every run of cells of that shade.
    fn paint(&self, svg: &mut String, [w, h]: [f64; 2], fastest: f64) {
        let [nx, ny] = self.cells;
        let (dx, dy) = (w / nx as f64, h / ny as f64);
        let shade = |cell: usize| self.flow[cell].map(|[u, v]| shade(u.hypot(v) / fastest));
        let mut paths = vec![String::new(); SHADES];
        for row in 0..ny {
            let mut x = 0;
            while x < nx {
                let now = shade(row * nx + x);
                let run = (x..nx).take_while(|i| shade(row * nx + i) == now).count();
                if let Some(now) = now {
                    let (left, top) = (x as f64 * dx, h - (row + 1) as f64 * dy);
                    let _ = write!(
                        paths[now],
                        "M{left:.1} {top:.1}h{:.1}v{dy:.1}h-{:.1}z",
                        run as f64 * dx,
                        run as f64 * dx
                    );
                }
                x += run;
            }
        }
        for (shade, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
            let _ = writeln!(svg, "<path fill='{0}' stroke='{0}' stroke-width='.3' d='{path}'/>", colour(shade));
        }
    }

    /// Arrows in every so many cells; their length goes with the square root of the speed, so that slow flow has a
    /// direction, too.
    fn arrows(&self, svg: &mut String, [w, h]: [f64; 2], fastest: f64) {
        let [nx, ny] = self.cells;
        let stride = nx.max(ny).div_ceil(ARROWS).max(1);
        let (dx, dy) = (w / nx as f64, h / ny as f64);
        let longest = 0.9 * stride as f64 * dx.min(dy);
        let mut path = String::new();
        for (row, column) in
            (stride / 2..ny).step_by(stride).flat_map(|r| (stride / 2..nx).step_by(stride).map(move |c| (r, c)))
        {
            let Some([u, v]) = self.flow[row * nx + column] else { continue };
            let speed = u.hypot(v);
            if speed < 1e-4 * fastest {
                continue;
            }
            let length = longest * (speed / fastest).sqrt();
            let (ax, ay) = (length * u / speed, -length * v / speed);
            let (x, y) = ((column as f64 + 0.5) * dx - ax / 2.0, h - (row as f64 + 0.5) * dy - ay / 2.0);
            // The head: two strokes of a third of the length, 25 degrees off.
            let head = |turn: f64| {
                let (sin, cos) = turn.sin_cos();
                (-(ax * cos - ay * sin) / 3.0, -(ax * sin + ay * cos) / 3.0)
            };
            let ((lx, ly), (rx, ry)) = (head(0.44), head(-0.44));
            let _ =
                write!(path, "M{x:.1} {y:.1}l{ax:.1} {ay:.1}l{lx:.1} {ly:.1}m{:.1} {:.1}l{rx:.1} {ry:.1}", -lx, -ly);
        }
        let _ = writeln!(svg, "<path fill='none' stroke='#1b1b1b' stroke-width='1.1' d='{path}'/>");
    }

    fn axes(&self, svg: &mut String, [w, h]: [f64; 2], scale: f64) {
        let [left, right, low, high] = self.ends;
        for tick in ticks(left, right) {
            let x = (tick - left) * scale;
            let _ = writeln!(
                svg,
                "<path stroke='#333' d='M{x:.1} {h:.1}v5'/><text x='{x:.1}' y='{:.1}' text-anchor='middle'>{tick}</text>",
                h + 19.0
            );
        }
        for tick in ticks(low, high) {
            let y = (high - tick) * scale;
            let _ = writeln!(
                svg,
                "<path stroke='#333' d='M0 {y:.1}h-5'/><text x='-9' y='{:.1}' text-anchor='end'>{tick}</text>",
                y + 4.5
            );
        }
        let _ = writeln!(
            svg,
            "<text x='{:.1}' y='{:.1}' font-size='16' text-anchor='middle'>{}</text>",
            w / 2.0,
            h + 44.0,
            escaped(&self.x)
        );
        let _ = writeln!(
            svg,
            "<text transform='translate(-46 {:.1}) rotate(-90)' font-size='16' text-anchor='middle'>{}</text>",
            h / 2.0,
            escaped(&self.y)
        );
    }

    /// The scale of the colours at the right.
    fn bar(&self, svg: &mut String, [w, h]: [f64; 2], fastest: f64) {
        let step = h / SHADES as f64;
        for shade in 0..SHADES {
            let y = h - (shade + 1) as f64 * step;
            let _ = writeln!(
                svg,
                "<rect x='{:.1}' y='{y:.1}' width='16' height='{:.1}' fill='{}'/>",
                w + 20.0,
                step + 0.3,
                colour(shade)
            );
        }
        for part in 0..=4u32 {
            let share = f64::from(part) / 4.0;
            let _ = writeln!(
                svg,
                "<text x='{:.1}' y='{:.1}'>{}</text>",
                w + 42.0,
                h * (1.0 - share) + 4.5,
                digits(share * fastest)
            );
        }
        let _ = writeln!(
            svg,
            "<text transform='translate({:.1} {:.1}) rotate(-90)' text-anchor='middle'>{}</text>",
            w + 108.0,
            h / 2.0,
            escaped(&self.colour)
        );
    }
}

fn shade(share: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let shade = (share * SHADES as f64) as usize;
    shade.min(SHADES - 1)
}

fn colour(shade: usize) -> String {
    let at = shade as f64 / (SHADES - 1) as f64 * (COLOURS.len() - 1) as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let low = (at as usize).min(COLOURS.len() - 2);
    let mix = |k: usize| {
        let value = COLOURS[low][k] + (at - low as f64) * (COLOURS[low + 1][k] - COLOURS[low][k]);
        format!("{:02x}", value.round() as i64)
    };
    format!("#{}{}{}", mix(0), mix(1), mix(2))
}

/// Round numbers between two ends, at most eight.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 7.0;
    let ten = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * ten).into_iter().find(|s| *s >= rough).unwrap_or(10.0 * ten);
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    let mut list = Vec::new();
    let mut i = first;
    while i <= last {
        // Adding zero makes a negative zero positive; rounding takes off what the product added.
        list.push((i * step / ten).round() * ten + 0.0);
        i += 1.0;
    }
    list
}

/// Three digits.
fn digits(v: f64) -> String {
    if v == 0.0 || (1e-3..1e4).contains(&v.abs()) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let places = if v == 0.0 { 0 } else { (2.0 - v.abs().log10().floor()).max(0.0) as usize };
        format!("{v:.places$}")
    } else {
        format!("{v:.1e}")
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks(0.0, 24.0), [0.0, 5.0, 10.0, 15.0, 20.0]);
        assert_eq!(ticks(-3.0, 3.0), [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0]);
        assert_eq!(ticks(0.0, 0.7), [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7].map(|t: f64| (t * 10.0).round() * 0.1));
    }

    #[test]
    fn every_known_cell_is_painted_once() {
        let flow = vec![Some([1.0, 0.0]), Some([1.0, 0.0]), None, Some([0.0, 0.5])];
        let map = Map { ends: [0.0, 2.0, 0.0, 2.0], cells: [2, 2], flow, ..Map::default() };
        let mut svg = String::new();
        map.paint(&mut svg, [100.0, 100.0], 1.0);
        // The lower row is one run of the fastest shade; of the upper row the right cell is half as fast.
        assert!(svg.contains("M0.0 50.0h100.0v50.0h-100.0z") && svg.contains("M50.0 0.0h50.0v50.0h-50.0z"), "{svg}");
        assert_eq!(svg.matches('z').count(), 2);
        assert!(map.svg().ends_with("</svg>\n"));
    }
}
