//! Charts as SVG: points with error bars, and a dashed line for what theory says.

use super::AnalyzeError;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::{
    BLACK, Cartesian2d, ChartBuilder, ChartContext, Circle, Color, DashedLineSeries, DrawingArea, IntoDrawingArea,
    IntoFont, IntoLogRange, PathElement, RGBColor, SVGBackend, SeriesLabelPosition, WHITE,
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

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Chart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<String, AnalyzeError> {
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (900, 560)).into_drawing_area();
            self.draw(&area)
                .map_err(|reason| AnalyzeError::TooLittle(format!("cannot draw `{}`: {reason}", self.title)))?;
        }
        Ok(svg)
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
        let mut y = self.range(bars.chain(guides().map(|g| g.1)));
        if self.scale == Scale::Linear {
            // Room for the legend: 18 of some 450 pixels a line. Logarithmic charts rise from the corner opposite to it.
            let lines = self.curves.iter().map(|c| 1.0 + f64::from(u8::from(c.guide.len() > 1))).sum::<f64>();
            y.end += (y.end - y.start) * (0.02 + 0.045 * lines).min(0.6);
        }
        let mut builder = ChartBuilder::on(area);
        builder.margin(16).x_label_area_size(48).y_label_area_size(84);
        builder.caption(&self.title, ("sans-serif", 22).into_font());
        match self.scale {
            Scale::Linear => {
                let mut chart = builder.build_cartesian_2d(x, y).map_err(|e| e.to_string())?;
                self.fill(&mut chart)
            }
            Scale::Logarithmic => {
                let mut chart = builder.build_cartesian_2d(x.log_scale(), y.log_scale()).map_err(|e| e.to_string())?;
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
            let color = PALETTE[i % PALETTE.len()];
            let shown = || curve.points.iter().filter(|(x, y, _)| self.shows(*x, *y));
            let bars = shown().filter(|(x, y, e)| self.shows(*x, y - e) && *e > 0.0);
            let bar = |(x, y, e): &(f64, f64, f64)| PathElement::new([(*x, y - e), (*x, y + e)], color.stroke_width(1));
            chart.draw_series(bars.map(bar)).map_err(|e| e.to_string())?;
            let dots = shown().map(|(x, y, _)| Circle::new((*x, *y), 3, color.filled()));
            let series = chart.draw_series(dots).map_err(|e| e.to_string())?;
            series.label(&curve.name).legend(move |(x, y)| Circle::new((x + 10, y), 3, color.filled()));
            let guide: Vec<(f64, f64)> = curve.guide.iter().copied().filter(|(x, y)| self.shows(*x, *y)).collect();
            if guide.len() < 2 {
                continue;
            }
            let dashes = DashedLineSeries::new(guide, 8, 5, color.stroke_width(2));
            let series = chart.draw_series(dashes).map_err(|e| e.to_string())?;
            let name = format!("{}, {}", curve.name.split(':').next().unwrap_or(""), curve.guide_name);
            series.label(name).legend(move |(x, y)| PathElement::new([(x, y), (x + 7, y)], color.stroke_width(2)));
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperLeft).background_style(WHITE.mix(0.85)).border_style(BLACK.mix(0.3));
        labels.label_font(("sans-serif", 14)).margin(8).draw().map_err(|e| e.to_string())
    }
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
