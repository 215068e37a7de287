//! One picture of a board.

use super::board::{Board, Track};
use crate::cli::watch;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, LineGauge, Paragraph, Sparkline};
use squirm::wire::{Stamp, Status};

/// Draws the board.
pub fn draw(frame: &mut Frame<'_>, board: &Board) {
    let rows = [3, 1, 4, 0, 1].map(Constraint::Length);
    let rows = Layout::vertical([rows[0], rows[1], rows[2], Constraint::Min(0), rows[4]]).split(frame.area());
    let foot = Paragraph::new("q: leave; the run goes on").style(dim());
    frame.render_widget(foot, rows[4]);
    let Some((stamp, status)) = &board.last else {
        frame.render_widget(Paragraph::new(format!("{}: waiting for its first status", board.run)), rows[0]);
        return;
    };
    head(frame, rows[0], board, status);
    progress(frame, rows[1], stamp, status);
    tracks(frame, rows[2], board, status);
    let halves = Layout::horizontal([Constraint::Percentage(60), Constraint::Percentage(40)]).split(rows[3]);
    stages(frame, halves[0], status);
    readers(frame, halves[1], board, status);
}

fn dim() -> Style {
    Style::new().add_modifier(Modifier::DIM)
}

fn bold() -> Style {
    Style::new().add_modifier(Modifier::BOLD)
}

fn head(frame: &mut Frame<'_>, area: Rect, board: &Board, status: &Status) {
    let colour = match (board.is_going(), board.died()) {
        (_, true) => Color::Red,
        (false, false) => Color::Green,
        (true, _) => Color::Reset,
    };
    let going = watch::time(watch::age(status));
    let lines = vec![
        Line::from(vec![
            Span::styled(board.run.clone(), bold()),
            Span::raw("  "),
            Span::styled(board.ending(), bold().fg(colour)),
        ]),
        Line::from(format!("process {}, going for {going}, on {}", status.pid, watch::tame(&status.adapter))),
        Line::from(format!("{} particles, writes into {}", status.particles, watch::tame(&status.folder))),
    ];
    frame.render_widget(Paragraph::new(lines), area);
}

fn progress(frame: &mut Frame<'_>, area: Rect, stamp: &Stamp, status: &Status) {
    let left = watch::left(stamp.step, status).map_or("?".into(), watch::time);
    let share = watch::share(stamp.step, status);
    let label =
        format!("step {} of {} ({share:.1} %), t = {:.1} tau, {left} left ", stamp.step, status.steps, stamp.time);
    let gauge = LineGauge::default().ratio((share / 100.0).clamp(0.0, 1.0)).label(label);
    frame.render_widget(gauge.filled_style(Style::new().fg(Color::Cyan)), area);
}

/// Speed, temperature and swim speed side by side.
fn tracks(frame: &mut Frame<'_>, area: Rect, board: &Board, status: &Status) {
    let columns = Layout::horizontal([Constraint::Ratio(1, 3); 3]).spacing(1).split(area);
    track(frame, columns[0], "steps/s", status.speed, &board.speed);
    track(frame, columns[1], "temperature [kT]", status.temperature, &board.temperature);
    track(frame, columns[2], "swim speed [sqrt(kT/m)]", status.swim_speed, &board.swim_speed);
}

fn track(frame: &mut Frame<'_>, area: Rect, name: &str, value: f64, track: &Track) {
    let rows = Layout::vertical([Constraint::Length(1), Constraint::Min(1), Constraint::Length(1)]).split(area);
    let width = usize::from(area.width);
    let now = if value.is_finite() { format!("{value:.4}") } else { "-".into() };
    let title = Line::from(vec![Span::styled(now, bold()), Span::raw(format!(" {name}"))]);
    frame.render_widget(Paragraph::new(title), rows[0]);
    let bars = Sparkline::default().data(track.heights(width)).max(8).style(Style::new().fg(Color::Cyan));
    frame.render_widget(bars, rows[1]);
    let range = track.range(width).map_or(String::new(), |(low, high)| format!("{low:.4} to {high:.4}"));
    frame.render_widget(Paragraph::new(range).style(dim()), rows[2]);
}

/// GPU time of the stages in the order of a step.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn stages(frame: &mut Frame<'_>, area: Rect, status: &Status) {
    let total: f64 = status.stages.iter().map(|s| s.1).sum();
    let width = usize::from(area.width).saturating_sub(32).clamp(12, 64);
    let block = Block::new().title(format!("GPU time by stage: {:.3} ms per step", total * 1e-6)).title_style(bold());
    let line = |(name, time): &(String, f64)| {
        let share = if total > 0.0 { 100.0 * time / total } else { 0.0 };
        let bar = "#".repeat((share / 5.0).round() as usize);
        Line::from(format!("{:<width$.width$} {share:5.1} %  {bar}", watch::tame(name)))
    };
    let lines: Vec<Line<'_>> = if status.stages.is_empty() {
        vec![Line::from("this adapter tells no times").style(dim())]
    } else {
        status.stages.iter().map(line).collect()
    };
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn readers(frame: &mut Frame<'_>, area: Rect, board: &Board, status: &Status) {
    let block = Block::new().title("topics").title_style(bold());
    let mut lines: Vec<Line<'_>> =
        board.topics.iter().map(|(kind, n)| Line::from(format!("{:<12} {n} subscribers", kind.topic()))).collect();
    if lines.is_empty() {
        lines.push(Line::from("no output publishes anything").style(dim()));
    }
    lines.push(Line::from(format!("{} snapshots published", status.published)));
    let dropped = Line::from(format!("{} dropped", status.dropped));
    lines.push(if status.dropped > 0 { dropped.style(Style::new().fg(Color::Red)) } else { dropped });
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

#[cfg(test)]
mod tests {
    use super::super::board::News;
    use super::*;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use squirm::wire::Kind;

    fn status() -> Status {
        Status {
            pid: 4711,
            steps: 2000,
            speed: 50.0,
            particles: 54_000,
            temperature: 1.0125,
            swim_speed: 0.083,
            published: 12,
            dropped: 3,
            stages: vec![("stream".into(), 3e6), ("cell-reduce".into(), 1e6)],
            phase: Status::RUNNING.into(),
            adapter: "llvmpipe".into(),
            folder: "/data/runs/quickstart".into(),
            ..Status::default()
        }
    }

    fn picture(board: &Board, width: u16, height: u16) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal");
        terminal.draw(|frame| draw(frame, board)).expect("drawn");
        let buffer = terminal.backend().buffer();
        let row = |y| (0..width).map(|x| buffer[(x, y)].symbol()).collect::<String>();
        (0..height).map(|y| row(y).trim_end().to_owned()).collect()
    }

    fn board() -> Board {
        let mut board = Board::new("quickstart");
        let stamp = Stamp { step: 500, time: 25.0, ..Stamp::default() };
        for speed in [40.0, 45.0, 50.0] {
            board.take(News::Status(stamp, Box::new(Status { speed, ..status() })));
        }
        board.take(News::Topics(vec![(Kind::Squirmers, 2), (Kind::Status, 1)]));
        board
    }

    #[test]
    fn one_picture_has_everything() {
        let lines = picture(&board(), 100, 20);
        let all = lines.join("\n");
        let parts = [
            "quickstart  running",
            "process 4711",
            "on llvmpipe",
            "54000 particles, writes into /data/runs/quickstart",
            "step 500 of 2000 (25.0 %), t = 25.0 tau, 30 s left",
            "50.0000 steps/s",
            "1.0125 temperature [kT]",
            "0.0830 swim speed",
            "40.0000 to 50.0000",
            "GPU time by stage: 4.000 ms per step",
            "squirmers    2 subscribers",
            "12 snapshots published",
            "3 dropped",
            "q: leave",
        ];
        parts.iter().for_each(|part| assert!(all.contains(part), "{part:?} is not in\n{all}"));
        assert!(all.contains('█') && all.contains('▂'), "bars:\n{all}");
        assert!(lines.iter().any(|l| l.contains("stream") && l.contains("75.0 %")), "{all}");
        assert!(!all.contains("status       1"), "the status is no topic of the user's");
    }

    #[test]
    fn an_end_is_shown_and_no_size_is_too_small() {
        let mut board = board();
        board.take(News::Over(None));
        assert!(picture(&board, 80, 24)[0].contains("the run has died after 500 steps or more"));
        for (width, height) in [(1, 1), (3, 40), (200, 2), (20, 7)] {
            picture(&board, width, height);
            picture(&Board::new("empty"), width, height);
        }
    }
}
