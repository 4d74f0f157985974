"""Files with five faults or more, each in another layer, and what is said of each line: the beginning."""

from __future__ import annotations

FILES: dict[str, tuple[str, list[tuple[int, str]]]] = {
    "keys, names, values and metrics": (
        """\
name = "a2"
speed_kt = 5
[start]
phase = "finall"
height_ft = -100
[autopilot]
bank_limit_deg = 80
[[checks]]
metric = "bnk_deg"
max = 3
""",
        [
            (2, "speed_kt: no such key; it belongs to another table: start.speed_kt or wind."),
            (4, "[start] phase must be one of downwind, base, final, not 'finall'"),
            (5, "[start] height_ft: must be above 0: a flight starts above the ground, and b"),
            (7, "[autopilot] bank_limit_deg: must be at most 60 (got 80)"),
            (9, "[[checks]] entry 0 metric: no metric 'bnk_deg'; did you mean 'bank_deg'?"),
        ],
    ),
    "an aircraft, a route that does not join, and what trackers listen to": (
        """\
name = "a3"
[aircraft]
model = "an26"
mass_lb = 90000
[route]
kind = "legs"
[[route.legs]]
from_m = [0, 0]
to_m = [20000, 0]
speed_kt = 40
height_m = 600
[[route.legs]]
from_m = [30000, 0]
to_m = [40000, 0]
speed_kt = 140
height_m = 600
[wind]
w20_kt = 20
turbulence = "light"
[sensors.r]
kind = "mls"
period_s = 0.001
[trackers.k]
kind = "kalman"
sensors = ["q"]
""",
        [
            (4, "[aircraft] mass of Antonov An-26 must lie within 35270 and 52910 lb, not 90"),
            (5, "[route] leg 0 ends (20000.0, 0.0), leg 1 begins (30000.0, 0.0): legs must j"),
            (19, "[wind] say 'turbulence' or 'w20_kt', not both"),
            (22, "[sensors.r] period_s: must be at least 0.00833333: the flight is not known "),
            (25, "[trackers.k] sensors: no sensor 'q'; allowed: r"),
        ],
    ),
    "values at the top, relations and tables": (
        """\
name = "4 a"
seed = 1.5
flights = 0
[runway]
latitude_deg = 89
touchdown_from_m = 900
touchdown_to_m = 100
[weather]
wind = 3
""",
        [
            (1, "name: must start with a letter and have at most 64 letters, digits, _ and -"),
            (2, "seed: must be a whole number (got 1.5)"),
            (3, "flights: must be at least 1 (got 0)"),
            (5, "[runway] latitude_deg: must be at most 85: the local metric fails near a po"),
            (6, "[runway] touchdown_from must lie before touchdown_to (got touchdown_from_m "),
            (8, "weather: no such key; allowed: air, aircraft, autopilot, checks, contrasts,"),
        ],
    ),
    "units, types and names of trackers": (
        """\
name = "a5"
[sensors.radar]
kind = "surveillance_radar"
period = 4
position_sigma_m = "100"
[trackers.imm]
kind = "imm"
handover = "kalmann"
models = 3
[autopilot]
navigation = "imn"
[autopilot.law]
k1 = 0.5
""",
        [
            (4, "[sensors.radar] period: no such key; it needs its unit: period_s or period_"),
            (5, "[sensors.radar] position_sigma_m: must be a number (got '100')"),
            (8, "[trackers.imm] handover: no other tracker 'kalmann'; there are none"),
            (9, "[trackers.imm] models: no such key; allowed: acceleration_g, acceleration_m"),
            (11, "[autopilot] navigation: no tracker 'imn'; did you mean 'imm'?"),
            (13, "[autopilot.law] k1: no such key; it needs its unit: k1_deg_per_m"),
        ],
    ),
    "events, departures and entries of arrays": (
        """\
name = "a6"
[wind.events.g]
kind = "gust"
speed_kt = 30
[wind.events.b]
kind = "microbrst"
[[departures]]
at_s = -5
flies = "bank"
[[sensor_faults]]
at_s = 10
sensor = "rdr"
error_factor = 2
[[contrasts]]
of = "a"
against = "a"
""",
        [
            (2, "[wind.events.g] a gust comes at a time (at, lasts) or at a place (past_thre"),
            (6, "[wind.events.b] kind: no kind 'microbrst'; did you mean 'microburst'?"),
            (8, "[[departures]] entry 0 at_s: must be at least 0: a flight begins at 0 s (go"),
            (12, "[[sensor_faults]] entry 0 sensor: no sensor 'rdr'; there are none"),
            (15, "[[contrasts]] entry 0 a contrast needs two trackers, and 'a' is one: give t"),
        ],
    ),
    "axes of a study": (
        """\
name = "a7"
[study]
samples = 0
[study.axes]
"wind.speed_mps" = { unifrom = [0, 5] }
"seed" = [1, 2]
"wind.sped_mps" = [1, 2]
[[checks]]
metric = "bank_deg"
max = 3
share = 1.5
[start]
cross_track = 100
""",
        [
            (3, "[study] samples: must be at least 1 (got 0)"),
            (5, "[study] axes \"wind.speed_mps\": no form 'unifrom'; did you mean 'uniform'?"),
            (6, "[study] axes \"seed\": 'seed' belongs to the whole study and is no axis"),
            (7, '[study] axes "wind.sped_mps": [wind] sped_mps: no such key; did you mean \'s'),
            (11, "[[checks]] entry 0 share: must be below 1 (got 1.5)"),
            (13, "[start] cross_track: no such key; it needs its unit: cross_track_m or cross"),
        ],
    ),
    "factors of an aircraft, and what trackers are designed for": (
        """\
name = "a8"
[aircraft]
model = "an26"
[aircraft.factors]
lift = 1.1
[route]
height_m = 40000
downwind_speed_kt = 1
[sensors.radar]
kind = "surveillance_radar"
[trackers.t]
kind = "saturated_control"
sub_step_s = 1e-4
[trackers.u]
kind = "kalman"
association = "probabilstic"
""",
        [
            (5, "[aircraft] 'an26' has no factor 'lift': known are lift_slope, drag, pitch_s"),
            (7, "[route] height_m: must be at most 30000 (got 40000)"),
            (8, "[route] downwind_speed_kt: must be at least 1.94384 (got 1)"),
            (13, "[trackers.t] sub_step must be at least 0.01 s, not 0.0001 s"),
            (16, "[trackers.u] association: must be 'probabilistic' (got 'probabilstic')"),
        ],
    ),
    "TOML itself, a header among it": (
        """\
name = "a9"
until_s = "60"
[start
leg = 0
[air]
temperature_c = 200
qnh_hpa = 29.92
[wind]
from_deg = 90
speed_mps = = 3
[[checks]]
max = 3
""",
        [
            (2, "until_s: must be a number (got '60')"),
            (3, "not TOML: Expected ']' at the end of a table declaration (at line 3, column"),
            (6, "[air] temperature_c: must be at most 60: nothing colder or hotter was ever "),
            (7, "[air] qnh_hpa: must be at least 850: nothing lower or higher was ever measu"),
            (10, "not TOML: Invalid value (at line 10, column 13)"),
        ],
    ),
}
