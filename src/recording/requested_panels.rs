//! Panels for the plots that a manifest requests, in front of the other plots of the viewer's layout.

use crate::header::Header;
use serde_json::{Map, Value, json};

/// A plot that the manifest requests.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PanelRequest {
    /// What it shows: a chart of the analysis, metrics, or fields of channels such as `/energy.kinetic_j`.
    pub subjects: Vec<String>,
    /// Its title, if it has one of its own.
    pub title: Option<String>,
}

/// A panel over time that shows what charts and metrics of the analysis show.
struct KnownPanel {
    model: &'static str,
    /// The charts, metrics and fields.
    subjects: &'static [&'static str],
    /// The panel's name in the layout.
    id: &'static str,
    /// The panel if the template has none of this name.
    added: Option<AddedPanel>,
}

struct AddedPanel {
    title: &'static str,
    y_label: &'static str,
    /// Fields with the labels of their curves.
    curves: &'static [(&'static str, &'static str)],
}

const KNOWN: &[KnownPanel] = &[
    in_template(
        "dem",
        "Plot!energy",
        &["energy_balance", "energy_total_by_run", "/energy.kinetic_j"],
    ),
    in_template("dem", "Plot!residual", &["energy_drift", "energy_residual_by_run"]),
    in_template("dem", "Plot!temperature", &["cooling", "granular_temperature", "cooling.rate"]),
    in_template("dem", "Plot!discharge", &["discharge", "outlet.discharge_rate"]),
    KnownPanel {
        model: "dem",
        subjects: &["piston.force", "floor.force"],
        id: "Plot!floor",
        added: Some(AddedPanel {
            title: "Upward force of the floor, and of the manifest's first wall",
            y_label: "force (N)",
            // The box has four walls, of which the third is the floor.
            curves: &[
                ("/wall_forces.mean_force_y_n[2]", "floor of the box"),
                ("/wall_forces.mean_force_y_n[4]", "first wall"),
            ],
        }),
    },
    in_template("gas", "Plot!pressure", &["pressure_over_time", "pressure.measured"]),
    in_template("gas", "Plot!temperature", &["temperature_over_time"]),
    in_template("gas", "Plot!collisions", &["wall_collisions_over_time", "wall_collision_rate"]),
    in_template("gas", "Plot!speeds", &["speed_histogram"]),
    KnownPanel {
        model: "gas",
        subjects: &["escaped_over_time", "effusion_rate"],
        id: "Plot!escaped",
        added: Some(AddedPanel {
            title: "Particles that have left through the orifice",
            y_label: "particles",
            curves: &[("/energy_balance.particles_escaped", "escaped")],
        }),
    },
    KnownPanel {
        model: "gas",
        subjects: &["h_over_time", "relative_entropy"],
        id: "Plot!entropy",
        added: Some(AddedPanel {
            title: "Distance of the speeds from Maxwell's distribution",
            y_label: "H - H_min",
            curves: &[("/energy_balance.relative_entropy", "measured")],
        }),
    },
    KnownPanel {
        model: "gas",
        subjects: &["density_by_height", "layers.mean_height", "layers.chi_square_per_layer"],
        id: "Plot!kinetic",
        added: Some(AddedPanel {
            // In gravity, the sum of kinetic and potential energy, N m g times the mean height, is conserved.
            title: "Kinetic energy: constant while the mean height of the particles is",
            y_label: "energy (J)",
            curves: &[("/energy.kinetic_j", "kinetic")],
        }),
    },
    in_template("packing", "Plot!temperature", &["temperature", "temperature_by_run"]),
    in_template("packing", "Plot!a2", &["a2", "a2.mean"]),
    in_template("packing", "Plot!rate", &["collision_rate", "pair_collision_rate_per_disc"]),
    in_template("packing", "Plot!factor", &["pressure_over_time", "compressibility_factor"]),
    in_template("orbit", "Plot!axis", &["semi_major_axis"]),
    // The separation of two bodies at one distance from a third is the chord of the angle between them.
    in_template(
        "orbit",
        "Plot!closest",
        &["closest_approach", "angle_by_run", "rotating_frame", "return_distance.final"],
    ),
    in_template(
        "orbit",
        "Plot!energy",
        &[
            "energy_drift",
            "energy_error_by_run",
            "energy.max_error_relative",
            "energy.drift_per_revolution",
        ],
    ),
    KnownPanel {
        model: "orbit",
        subjects: &["position_error", "position_error_by_run", "position_error.final"],
        id: "Plot!position",
        added: Some(AddedPanel {
            title: "Distance from the exact position",
            y_label: "distance (AU)",
            curves: &[("/orbit.position_error_au", "error")],
        }),
    },
];

const fn in_template(
    model: &'static str,
    id: &'static str,
    subjects: &'static [&'static str],
) -> KnownPanel {
    KnownPanel { model, subjects, id, added: None }
}

/// Maximum number of plots in the right column, on a screen of 1080 px.
const MOST_PLOTS: usize = 6;
/// Colors of curves, as in the templates.
const COLORS: [&str; 4] = ["#5aa9e6", "#f0a04b", "#ef7d57", "#9a9a9a"];
/// Maximum number of characters of a curve's label, for which the legend has room.
const LONGEST_LABEL: usize = 16;

/// Adds the panels for the requests to those of the template, and returns the names of the panels that show them, in the order of the
/// requests. A request that no recorded field can show over time has none.
pub(crate) fn add_requested(
    panels: &mut Map<String, Value>,
    requests: &[PanelRequest],
    header: &Header,
) -> Vec<String> {
    let over_time = |panel: &&Value| panel["xAxisVal"] == "timestamp";
    let Some(pattern) = panels.values().find(over_time).cloned() else { return Vec::new() };
    let mut requested: Vec<String> = Vec::new();
    for (index, request) in requests.iter().enumerate() {
        let is_asked = |subject: &str| request.subjects.iter().any(|asked| asked == subject);
        let known = KNOWN.iter().find(|known| {
            known.model == header.model && known.subjects.iter().any(|subject| is_asked(subject))
        });
        let shows = |panel: &Value| {
            let paths = panel["paths"].as_array().into_iter().flatten();
            paths.filter_map(|path| path["value"].as_str()).any(is_asked)
        };
        let is_field = request.subjects.first().is_some_and(|subject| subject.starts_with('/'));
        let id = match (known, panels.iter().find(|(_, panel)| shows(panel))) {
            (Some(known), _) => {
                let added = known.added.as_ref().filter(|_| !panels.contains_key(known.id));
                if let Some(added) = added {
                    panels.insert(known.id.to_owned(), added.panel(&pattern));
                }
                known.id.to_owned()
            }
            (None, Some((id, _))) => id.clone(),
            (None, None) if is_field => {
                let id = format!("Plot!request{}", index + 1);
                panels.insert(id.clone(), of_fields(request, &pattern));
                id
            }
            (None, None) => continue,
        };
        if !requested.contains(&id) {
            requested.push(id);
        }
    }
    requested
}

impl AddedPanel {
    fn panel(&self, pattern: &Value) -> Value {
        let curves = self.curves.iter().map(|(path, label)| ((*path).to_owned(), *label));
        panel(pattern, self.title, self.y_label, curves)
    }
}

/// A panel of the fields that a request names.
fn of_fields(request: &PanelRequest, pattern: &Value) -> Value {
    let words = |path: &str| path.rsplit('.').next().unwrap_or(path).replace('_', " ");
    let names: Vec<String> = request.subjects.iter().map(|path| words(path)).collect();
    let label = |name: &str| -> String { name.chars().take(LONGEST_LABEL).collect() };
    let labels: Vec<String> = names.iter().map(|name| label(name)).collect();
    let first = names.first().map_or("", String::as_str);
    let title = request.title.as_deref().unwrap_or(first);
    let curves = request.subjects.iter().cloned().zip(labels.iter().map(String::as_str));
    panel(pattern, title, first, curves)
}

fn panel<'a>(
    pattern: &Value,
    title: &str,
    y_label: &str,
    curves: impl Iterator<Item = (String, &'a str)>,
) -> Value {
    let mut panel = pattern.clone();
    let curve = |(index, (path, label)): (usize, (String, &str))| {
        let mut curve = pattern["paths"][0].clone();
        curve["value"] = json!(path);
        curve["label"] = json!(label);
        curve["color"] = json!(COLORS[index % COLORS.len()]);
        curve
    };
    panel["paths"] = curves.enumerate().map(curve).collect();
    panel["yAxisLabel"] = json!(y_label);
    panel["foxglovePanelTitle"] = json!(title);
    panel["lichtblickPanelTitle"] = json!(title);
    panel
}

/// Puts the requested plots at the top of the right column of a layout's tree, at twice the height of the others. Plots for which there
/// is no room leave the layout.
pub(crate) fn move_to_the_top(
    tree: &mut Value,
    panels: &mut Map<String, Value>,
    requested: &[String],
) {
    let mut column: Vec<String> =
        requested.iter().filter(|id| panels.contains_key(*id)).cloned().collect();
    if column.is_empty() {
        return;
    }
    let shown = column.len();
    let mut others = Vec::new();
    leaves(&tree["second"], &mut others);
    column.extend(others.into_iter().filter(|id| !requested.contains(id)));
    for id in column.drain(column.len().min(MOST_PLOTS.max(shown))..) {
        panels.remove(&id);
    }
    let heights = (0..column.len()).map(|index| if index < shown { 2.0 } else { 1.0 });
    let stacked = column.into_iter().zip(heights).rev().fold(None, |below, (id, height)| {
        let Some((below, total)) = below else { return Some((json!(id), height)) };
        let node = json!({
            "direction": "column",
            "splitPercentage": 100.0 * height / (height + total),
            "first": id,
            "second": below,
        });
        Some((node, height + total))
    });
    if let Some((stacked, _)) = stacked {
        tree["second"] = stacked;
    }
}

fn leaves(tree: &Value, into: &mut Vec<String>) {
    match tree {
        Value::String(id) => into.push(id.clone()),
        Value::Object(node) => ["first", "second"]
            .iter()
            .filter_map(|side| node.get(*side))
            .for_each(|side| leaves(side, into)),
        _ => {}
    }
}
