//! `utm-sky chart`: its files hold together, and its printed factors are those of its figures. Needs a
//! Vulkan driver.

use std::collections::BTreeMap;
use std::fs;

use tempfile::tempdir;

use crate::support::{names, refuse, succeed};

const HEAD: &str = "model,tier,regime,valid_share,delta_e_p50,delta_e_p95,luminance_p95,\
radiance_rmse_mw_m2_sr_nm,cpu_ns_per_direction,gpu_ns_per_pixel_1080p,gpu_ns_per_pixel_2160p,\
ratio_to_floor,update_us,rebuild_ms,table_bytes,on_front,adapter";

const REGIMES: [&str; 7] = [
    "all",
    "horizon-band",
    "aureole",
    "high-sun",
    "low-sun",
    "twilight",
    "aloft",
];

const MODELS: [&str; 4] = ["utm-sky-baked", "preetham", "nishita", "bruneton"];

/// A row by its columns.
type Row = BTreeMap<String, String>;

fn rows(csv: &str) -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    reader
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("rows")
}

fn number(row: &Row, column: &str) -> Option<f64> {
    row[column].parse().ok()
}

#[test]
fn the_chart_s_files_hold_together() {
    let dir = tempdir().expect("a directory");
    refuse(dir.path(), "chart --models nobody", &["nobody", "preetham"]);
    let line = format!("chart --quick --models {} --out chart", MODELS.join(","));
    let printed = succeed(dir.path(), &line).stdout;
    let out = dir.path().join("chart");
    assert_eq!(
        names(&out),
        ["chart.csv", "chart.html", "chart.svg", "offline.csv"]
    );
    let read = |name: &str| fs::read_to_string(out.join(name)).expect("a file");
    let text = read("chart.csv");
    assert_eq!(text.lines().next(), Some(HEAD));
    let rows = rows(&text);
    let order: Vec<[&str; 2]> = rows
        .iter()
        .map(|row| [row["model"].as_str(), row["regime"].as_str()])
        .collect();
    let wanted: Vec<[&str; 2]> = MODELS
        .iter()
        .flat_map(|model| REGIMES.map(|regime| [*model, regime]))
        .collect();
    assert_eq!(order, wanted);

    // the front: nothing is cheaper and closer at once; who lacks a cost is not on it
    for regime in REGIMES {
        let here: Vec<&Row> = rows.iter().filter(|row| row["regime"] == regime).collect();
        let place = |row: &Row| {
            Some([
                number(row, "gpu_ns_per_pixel_1080p")?,
                number(row, "delta_e_p95")?,
            ])
        };
        for row in &here {
            let beaten = place(row).is_none_or(|[cost, error]| {
                let others = here.iter().filter_map(|other| place(other));
                others.into_iter().any(|[c, e]| c < cost && e < error)
            });
            assert_eq!(row["on_front"] == "true", !beaten, "{row:?}");
        }
    }

    // what each model is known for
    let all = |model: &str| {
        rows.iter()
            .find(|row| row["model"] == model && row["regime"] == "all")
            .expect("a row")
    };
    let value = |model: &str, column: &str| number(all(model), column).expect("a number");
    assert!(value("utm-sky-baked", "valid_share") > 0.999);
    assert!(value("preetham", "valid_share") < 0.2);
    assert!(all("bruneton")["gpu_ns_per_pixel_1080p"].is_empty());
    let ours = value("utm-sky-baked", "delta_e_p95");
    for model in &MODELS[1..] {
        let theirs = value(model, "delta_e_p95");
        assert!(theirs > ours, "{model}: {theirs}, ours {ours}");
        // the printed factor is the figures' own
        let said = printed
            .lines()
            .find(|line| line.starts_with(model))
            .expect("a line");
        let factor: f64 = said
            .split_whitespace()
            .nth(3)
            .and_then(|word| word.parse().ok())
            .expect("a factor");
        assert!((factor - theirs / ours).abs() < 0.01, "{said}");
    }
    assert!(printed.contains("utm-sky-baked: "), "{printed}");

    // the drawings: on the page a panel a regime, on the sheet the most telling; a word a model
    let (svg, page) = (read("chart.svg"), read("chart.html"));
    for title in ["All cases", "Sun 70–90°", "From 9 km"] {
        assert!(svg.contains(&format!(">{title}")), "{title}");
    }
    for regime in REGIMES {
        assert!(page.contains(&format!("<h3>{regime}</h3>")), "{regime}");
    }
    for model in ["utm-sky-baked", "preetham", "nishita"] {
        assert!(svg.contains(model) && page.contains(model), "{model}");
    }
    // Preetham's air is his own
    assert!(svg.contains("preetham*") && !svg.contains("utm-sky-baked*"));
    assert!(svg.contains("* air of its own"));
    for id in ["regimes", "factors", "offline", "models"] {
        assert!(page.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    assert!(!page.contains("NaN") && !svg.contains("NaN"));
    for address in ["http://", "https://"] {
        assert!(!page.contains(address), "{address}");
    }

    // the settings of the offline side: coarser wavelengths are further from the truth
    let offline = self::rows(&read("offline.csv"));
    let [coarse, default] = ["20 nm", "10 nm"].map(|value| {
        let row = offline.iter().find(|row| row["value"] == value);
        row.expect("a row")
    });
    assert_eq!(coarse["default"], "false");
    assert_eq!(default["default"], "true");
    assert!(number(coarse, "delta_e_p95") > number(default, "delta_e_p95"));
    assert!(number(default, "seconds").expect("a number") > 0.0);
}
