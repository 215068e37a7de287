//! Charts as SVG: points with error bars, and a dashed line for what theory says.

use super::AnalyzeError;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::{
    BLACK, Cartesian2d, ChartBuilder, ChartContext, Circle, Color, DashedLineSeries, DrawingArea, IntoDrawingArea,
    IntoFont, IntoLogRange, PathElement, RGBColor, SVGBackend, ShapeStyle, Text, WHITE,
};

/// Colours that remain apart for the colour-blind (Okabe and Ito 2008), without the light ones.
const PALETTE: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Both axes linear, or both logarithmic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Both linear.
    Linear,
    /// Both logarithmic.
    Logarithmic,
}

/// One set of points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// In the legend.
    pub name: String,
    /// x, y, error of y.
    pub points: Vec<(f64, f64, f64)>,
    /// What to compare with, as a dashed line.
    pub guide: Vec<(f64, f64)>,
    /// In the legend.
    pub guide_name: String,
}

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Caption.
    pub title: String,
    /// Label of the x axis.
    pub x: String,
    /// Label of the y axis.
    pub y: String,
    /// Of both axes.
    pub scale: Scale,
    /// What is drawn.
    pub curves: Vec<Curve>,
}

/// Pixels of the axes with their labels.
const SIZE: (u32, u32) = (900, 560);

/// Pixels of a line of the legend.
const LINE: u32 = 20;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Chart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<String, AnalyzeError> {
        let mut svg = String::new();
        {
            let (_, lines) = self.legend();
            let size = (SIZE.0, SIZE.1 + (lines + 1) * LINE);
            let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
            self.draw(&area)
                .map_err(|reason| AnalyzeError::TooLittle(format!("cannot draw `{}`: {reason}", self.title)))?;
        }
        Ok(svg)
    }

    /// What the legend says of a curve.
    fn entry(curve: &Curve) -> String {
        if curve.guide.len() > 1 {
            format!("{} (dashed: {})", curve.name, curve.guide_name)
        } else {
            curve.name.clone()
        }
    }

    /// Columns and lines of the legend: two columns where names are short.
    fn legend(&self) -> (u32, u32) {
        let columns = if self.curves.iter().all(|c| Self::entry(c).chars().count() < 54) { 2 } else { 1 };
        let count = u32::try_from(self.curves.len()).unwrap_or(u32::MAX);
        (columns, count.div_ceil(columns))
    }

    /// The legend below the axes, where it hides nothing.
    fn explain(&self, area: &Area<'_>) -> Result<(), String> {
        let (columns, lines) = self.legend();
        let width = SIZE.0 / columns;
        let at = |pixel: u32| i32::try_from(pixel).unwrap_or(i32::MAX);
        for (i, curve) in (0u32..).zip(&self.curves) {
            let (x, y) = (at(40 + i / lines * width), at(10 + i % lines * LINE));
            let (color, mark) = style(i as usize);
            let draw = |e: Result<(), _>| e.map_err(|e: plotters::drawing::DrawingAreaErrorKind<_>| e.to_string());
            draw(area.draw(&Circle::new((x, y), 3, mark)))?;
            if curve.guide.len() > 1 {
                for dash in [12, 24] {
                    draw(area.draw(&PathElement::new([(x + dash, y), (x + dash + 8, y)], color.stroke_width(2))))?;
                }
            }
            draw(area.draw(&Text::new(Self::entry(curve), (x + 44, y - 7), ("sans-serif", 14).into_font())))?;
        }
        Ok(())
    }

    /// Whether a point has a place on the axes.
    fn shows(&self, x: f64, y: f64) -> bool {
        x.is_finite() && y.is_finite() && (self.scale == Scale::Linear || (x > 0.0 && y > 0.0))
    }

    /// Smallest and largest value with a margin; an error bar that would leave the axes does not count.
    fn range(&self, values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
        let positive = self.scale == Scale::Logarithmic;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| v.is_finite() && (!positive || *v > 0.0)) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            return 1.0..10.0;
        }
        if positive { low / 1.3..high * 1.3 } else { margin(low, high) }
    }

    fn draw(&self, area: &Area<'_>) -> Result<(), String> {
        area.fill(&WHITE).map_err(|e| e.to_string())?;
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let guides = || self.curves.iter().flat_map(|c| &c.guide);
        let x = self.range(points().map(|p| p.0).chain(guides().map(|g| g.0)));
        let bars = points().flat_map(|(_, y, e)| [*y, y - e, y + e]);
        let y = self.range(bars.chain(guides().map(|g| g.1)));
        let (axes, legend) = area.split_vertically(SIZE.1);
        self.explain(&legend)?;
        let mut builder = ChartBuilder::on(&axes);
        builder.margin(16).x_label_area_size(48).y_label_area_size(84);
        builder.caption(&self.title, ("sans-serif", 22).into_font());
        match self.scale {
            Scale::Linear => {
                let mut chart = builder.build_cartesian_2d(x, y).map_err(|e| e.to_string())?;
                self.fill(&mut chart)
            }
            Scale::Logarithmic => {
                // Labels stand at powers of the base: over few decades there are too few of ten.
                let base = |range: &std::ops::Range<f64>| if range.end < 200.0 * range.start { 2.0 } else { 10.0 };
                let (x_base, y_base) = (base(&x), base(&y));
                let (x, y) = (x.log_scale().base(x_base), y.log_scale().base(y_base));
                let mut chart = builder.build_cartesian_2d(x, y).map_err(|e| e.to_string())?;
                self.fill(&mut chart)
            }
        }
    }

    fn fill<'a, 'b: 'a, X, Y>(
        &self,
        chart: &mut ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>,
    ) -> Result<(), String>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let label = |v: &f64| short(*v);
        let mut mesh = chart.configure_mesh();
        mesh.x_desc(&self.x).y_desc(&self.y).x_label_formatter(&label).y_label_formatter(&label);
        mesh.axis_desc_style(("sans-serif", 16)).label_style(("sans-serif", 13)).light_line_style(BLACK.mix(0.04));
        mesh.x_labels(8).y_labels(8).draw().map_err(|e| e.to_string())?;
        for (i, curve) in self.curves.iter().enumerate() {
            let (color, mark) = style(i);
            let shown = || curve.points.iter().filter(|(x, y, _)| self.shows(*x, *y));
            let bars = shown().filter(|(x, y, e)| self.shows(*x, y - e) && *e > 0.0);
            let bar = |(x, y, e): &(f64, f64, f64)| PathElement::new([(*x, y - e), (*x, y + e)], color.stroke_width(1));
            chart.draw_series(bars.map(bar)).map_err(|e| e.to_string())?;
            let dots = shown().map(|(x, y, _)| Circle::new((*x, *y), 3, mark));
            chart.draw_series(dots).map_err(|e| e.to_string())?;
            let guide: Vec<(f64, f64)> = curve.guide.iter().copied().filter(|(x, y)| self.shows(*x, *y)).collect();
            if guide.len() > 1 {
                let dashes = DashedLineSeries::new(guide, 8, 5, color.stroke_width(2));
                chart.draw_series(dashes).map_err(|e| e.to_string())?;
            }
        }
        Ok(())
    }
}

/// Colour of a curve, and how its points are drawn: full circles, then open ones in the same colours.
fn style(curve: usize) -> (RGBColor, ShapeStyle) {
    let color = PALETTE[curve % PALETTE.len()];
    (color, if (curve / PALETTE.len()).is_multiple_of(2) { color.filled() } else { color.stroke_width(1) })
}

/// The interval with a tenth of its length added on both sides.
fn margin(low: f64, high: f64) -> std::ops::Range<f64> {
    let length = if high > low { high - low } else { low.abs().max(1e-3) };
    low - 0.1 * length..high + 0.1 * length
}

/// A number on an axis: four digits are enough to tell ticks apart.
fn short(v: f64) -> String {
    let size = v.abs();
    if size < 1e-12 {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{v:.1e}");
    }
    let text = format!("{v:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
