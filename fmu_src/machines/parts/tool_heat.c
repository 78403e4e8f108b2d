/* How warm does the contact get? Heat of the shear plane divides between chip and work, heat of the rake face between
 * chip and tool.
 *
 * Shear plane: the work keeps the share G of Weiner, with R = rho c v h/k the thermal number. The chip leaves with its
 * bulk temperature
 *     T_s = T_a + (1 - G) P_s/(rho c w h v).
 * Rake face: the chip, thickness t = h cos(phi - alpha)/sin(phi), passes it over a length l at v h/t, and becomes
 * warmer there by R_chip times the heat that it takes: by its mean, which also flows back along the chip to the shear
 * plane, and by the surface before the mean. For a fast, thick chip this is Jaeger's band on a half space. The tool
 * takes its part through the constriction below the contact, a rectangle at its edge, which the clearance face mirrors:
 *     C_c dT_c/dt = P_f - (T_c - T_s)/R_chip - (T_c - T_b)/R_c
 *     C_b dT_b/dt = (T_c - T_b)/R_c - (T_b - T_a)/R_b.
 * So both sides have the same mean temperature, as Blok asks for. T_c - T_s is the flash temperature.
 *
 * Powers are means over the vibration cycle: within one the contact swings about the mean by a few kelvin at most,
 * 2 q sqrt(t/pi)/(sum of both sqrt(k rho c)), 2 K for 15 MW/m^2 in 15 us.
 */
#include "../rows.h"

enum {
    DISSIPATED_POWER = INPUT_FIRST,
    SHEAR_POWER,
    CUTTING_SPEED,
    WIDTH,
    THICKNESS,
    CONTACT_LENGTH,
    SHEAR_ANGLE,
    RAKE_ANGLE,
    WORK_CONDUCTIVITY,
    WORK_CAPACITY,
    CONDUCTIVITY,
    HEAT_CAPACITY,
    BODY_CAPACITY,
    BODY_RESISTANCE,
    AMBIENT,
    TEMPERATURE,
    BODY_TEMPERATURE,
    BULK_TEMPERATURE,
    FLASH_TEMPERATURE,
    WORK_SHARE,
    CHIP_RESISTANCE,
    SPOT_RESISTANCE,
    SPOT_TIME,
    WORK_FLOW,
    CHIP_FLOW,
    HEAT_FLOW,
    HOLDER_FLOW,
    STORED,
    RATES,
    COUNT = RATES + 2
};

#define WARM .unit = "K", .display_unit = "degC", .start = 293.15, .nominal = 300
#define POWER .unit = "W", .min = -1e9, .max = 1e9, GIVEN
#define FLOW .unit = "W", RESULT

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [VAR_TIME] = CLOCK,
    [DISSIPATED_POWER] = {.name = "dissipated_power", POWER,
        .meaning = "power that friction turns into heat on the rake face, mean over the vibration cycle",
        .source = "the contact"},
    [SHEAR_POWER] = {.name = "shear_power", POWER,
        .meaning = "power that shears the chip, mean over the vibration cycle", .source = "the contact"},
    [CUTTING_SPEED] = {.name = "cutting_speed", .unit = "m/s", .display_unit = "m/min", .start = 10.0 / 60, .min = 0,
        .max = 1e2, GIVEN, .meaning = "speed of the work past the mean tool position", .source = "the machine"},
    [WIDTH] = {.name = "width", .unit = "m", .display_unit = "mm", .start = 1e-3, .min = 1e-6, .max = 1, .nominal = 1e-3,
        TUNED, .meaning = "width of cut, that of the contact", .source = "guess: the paper states none"},
    [THICKNESS] = {.name = "feed", .unit = "m", .display_unit = "mm", .start = 1e-4, .min = 1e-7, .max = 1e-2,
        .nominal = 1e-4, TUNED, .meaning = "nominal uncut thickness, that of the contact",
        .source = "guess: the paper states none"},
    [CONTACT_LENGTH] = {.name = "contact_length", .unit = "m", .display_unit = "mm", .start = 2.7e-4, .min = 1e-7,
        .max = 1e-1, .nominal = 1e-4, TUNED, .meaning = "length over which the chip touches the rake face",
        .source = "guess: chip thickness times 1 + tan(phi - alpha), as in the example of Ghosh and Mallik"},
    [SHEAR_ANGLE] = {.name = "chip_flow_shear_angle", .unit = "rad", .display_unit = "deg", .start = PI / 6, .min = 0.05,
        .max = 1.4, TUNED, .meaning = "shear angle, that of the contact", .source = "guess: 30 deg, ordinary for metals"},
    [RAKE_ANGLE] = {.name = "rake_angle", .unit = "rad", .display_unit = "deg", .min = -0.1, .max = 0.7, TUNED,
        .meaning = "rake angle of the tool, that of the contact", .source = "the paper, section 4.1: 0"},
    [WORK_CONDUCTIVITY] = {.name = "work_conductivity", .unit = "W/(m.K)", .start = 130, .min = 1e-2, .max = 1e4,
        .nominal = 10, TUNED, .meaning = "heat conductivity of the work",
        .source = "Al 7075 T6, common handbook value"},
    [WORK_CAPACITY] = {.name = "work_heat_capacity", .unit = "J/(m^3.K)", .start = 2.7e6, .min = 1e3, .max = 1e8,
        .nominal = 1e6, TUNED, .meaning = "heat capacity of the work by volume",
        .source = "Al 7075 T6, common handbook value"},
    [CONDUCTIVITY] = {.name = "conductivity", .unit = "W/(m.K)", .start = 80, .min = 1e-2, .max = 1e4, .nominal = 10,
        TUNED, .meaning = "heat conductivity of the tool", .source = "cemented carbide, common handbook value"},
    [HEAT_CAPACITY] = {.name = "heat_capacity", .unit = "J/(m^3.K)", .start = 3e6, .min = 1e3, .max = 1e8,
        .nominal = 1e6, TUNED, .meaning = "heat capacity of the tool by volume",
        .source = "cemented carbide, common handbook value"},
    [BODY_CAPACITY] = {.name = "insert_capacity", .unit = "J/K", .start = 2, .min = 1e-6, .max = 1e6, TUNED,
        .meaning = "heat capacity of the insert", .source = "guess: 12.7 mm square, 4.8 mm thick"},
    [BODY_RESISTANCE] = {.name = "insert_resistance", .unit = "K/W", .start = 2, .min = 1e-6, .max = 1e6, TUNED,
        .meaning = "thermal resistance between insert and ambient", .source = "guess"},
    [AMBIENT] = {.name = "ambient_temperature", WARM, .min = 0, .max = 2e3, TUNED,
        .meaning = "temperature of the holder, and of the work before it is cut", .source = "guess: 20 degC"},
    [TEMPERATURE] = {.name = "contact_temperature", WARM, RESULT,
        .meaning = "mean temperature of the contact between chip and tool",
        .source = "Blok 1937 (not read): the same on both sides"},
    [BODY_TEMPERATURE] = {.name = "insert_temperature", WARM, RESULT, .meaning = "bulk temperature of the insert",
        .source = "balance of heat"},
    [BULK_TEMPERATURE] = {.name = "bulk_temperature", WARM, RESULT,
        .meaning = "bulk temperature of the chip, as it leaves the shear plane",
        .source = "Loewen and Shaw 1954 (not read)"},
    [FLASH_TEMPERATURE] = {.name = "flash_temperature", .unit = "K", RESULT, .nominal = 100, .difference = 1,
        .meaning = "rise of contact_temperature above bulk_temperature", .source = "Blok 1937; Jaeger 1942 (neither read)"},
    [WORK_SHARE] = {.name = "work_share", .unit = "1", RESULT, .meaning = "share of shear_power that the work keeps",
        .source = "Weiner 1955 (abstract read; derived anew); range checked with Boothroyd's fit to experiments"},
    [CHIP_RESISTANCE] = {.name = "chip_resistance", .unit = "K/W", RESULT,
        .meaning = "mean rise of the chip along the contact over the heat that it takes there",
        .source = "heat equation of a strip; Jaeger 1942 (not read) where it is thick and fast"},
    [SPOT_RESISTANCE] = {.name = "spot_resistance", .unit = "K/W", RESULT,
        .meaning = "resistance R_c of the constriction in the tool",
        .source = "Loewen and Shaw 1954 (not read): mean over a rectangle on a half space, mirrored at the edge"},
    [SPOT_TIME] = {.name = "spot_time", .unit = "s", .display_unit = "ms", INNER, .nominal = 1e-3,
        .meaning = "time constant of the contact, C_c times R_c beside R_chip", .source = DEFINITION},
    [WORK_FLOW] = {.name = "work_heat_flow", FLOW, .meaning = "heat that the work keeps", .source = DEFINITION},
    [CHIP_FLOW] = {.name = "chip_heat_flow", FLOW, .meaning = "heat that the chip carries away, of both sources",
        .source = DEFINITION},
    [HEAT_FLOW] = {.name = "heat_flow", FLOW, .meaning = "heat that flows from contact to insert",
        .source = DEFINITION},
    [HOLDER_FLOW] = {.name = "holder_heat_flow", FLOW, .meaning = "heat that flows from insert to holder",
        .source = DEFINITION},
    [STORED] = {.name = "stored_heat", .unit = "J", RESULT, .meaning = "heat in contact and insert above ambient",
        .source = DEFINITION},
    [RATES] = {.name = "contact_heating", .unit = "K/s", INNER, .derivative_of = TEMPERATURE,
        .meaning = "rate of contact_temperature", .source = "balance of heat"},
    [RATES + 1] = {.name = "insert_heating", .unit = "K/s", INNER, .derivative_of = BODY_TEMPERATURE,
        .meaning = "rate of insert_temperature", .source = "balance of heat"},
};
/* clang-format on */

#define SLOWEST 1e-4 /* [m/s]: below it the heat of the shear plane goes as at it */

/* Weiner 1955: heat flows across the motion alone, Y = R tan(phi)/4. */
static double share_of_work(double Y)
{
    const double y = sqrt(Y);
    return erf(y) / (4 * Y) + (1 + Y) * erfc(y) - exp(-Y) / sqrt(PI) * (0.5 / y + y);
}

/* Mean rise along a strip that enters at its bulk temperature and is heated evenly over l, over q l^2/(k t); p = v l
 * over the diffusivity. 1/3 at rest, 1/(2 p) fast. */
static double mean_rise(double p)
{
    if (p < 0.01)
        return 1.0 / 3 - p * (1.0 / 8 - p * (1.0 / 30 - p * (1.0 / 144 - p / 840)));
    return (0.5 - (1 - exp(-p) * (1 + p)) / (p * p)) / p;
}

/* How far the strip's heated side is ahead of the mean across it, mean along l, over q t/k; tau = diffusivity l/(v
 * t^2). 4/3 sqrt(tau/pi) thick and fast, 1/3 slow. */
static double surface_rise(double per_tau)
{
    if (per_tau > 1 / 0.15)
        return 4 / (3 * sqrt(PI * per_tau)) - 0.5 / per_tau;
    double late = 0;
    for (int n = 1; n <= 3 && per_tau > 0; ++n)
        late += exp(-n * n * PI * PI / per_tau) / (n * n * n * n);
    return 1.0 / 3 - per_tau / 45 + 2 * per_tau * late / (PI * PI * PI * PI);
}

/* Mean temperature under even heat on a rectangle, over q a/k: sides 2a and 2b on a half space. b over a. */
static double of_rectangle(double r)
{
    return 2 / PI * (asinh(r) + r * asinh(1 / r) + r * r / 3 + 1 / (3 * r) - (r + 1 / r) * sqrt(1 + r * r) / 3);
}

static void evaluate(double *value)
{
    const double w = value[WIDTH], h = value[THICKNESS], l = value[CONTACT_LENGTH], v = fmax(value[CUTTING_SPEED], 0);
    const double phi = value[SHEAR_ANGLE], t = h * cos(phi - value[RAKE_ANGLE]) / sin(phi);
    const double k = value[WORK_CONDUCTIVITY], rho_c = value[WORK_CAPACITY], k_tool = value[CONDUCTIVITY];
    const double flow = rho_c * w * h * fmax(v, SLOWEST); /* of heat with the chip [W/K] */
    const double G = share_of_work(flow * tan(phi) / (4 * k * w));
    const double T_s = value[AMBIENT] + (1 - G) * value[SHEAR_POWER] / flow;
    const double v_chip = v * h / t;
    const double R_chip =
        (l * l / t * mean_rise(rho_c * v_chip * l / k) + t * surface_rise(rho_c * v_chip * t * t / (k * l))) /
        (k * l * w);
    const double R_c = of_rectangle(0.5 * w / l) / (k_tool * w), a = sqrt(l * w / PI),
                 C_c = 2 * PI / 3 * a * a * a * value[HEAT_CAPACITY], C_b = value[BODY_CAPACITY];
    const double T_c = value[TEMPERATURE], T_b = value[BODY_TEMPERATURE], to_chip = (T_c - T_s) / R_chip,
                 to_tool = (T_c - T_b) / R_c, to_holder = (T_b - value[AMBIENT]) / value[BODY_RESISTANCE];
    value[BULK_TEMPERATURE] = T_s;
    value[FLASH_TEMPERATURE] = T_c - T_s;
    value[WORK_SHARE] = G;
    value[CHIP_RESISTANCE] = R_chip;
    value[SPOT_RESISTANCE] = R_c;
    value[SPOT_TIME] = C_c * R_c * R_chip / (R_c + R_chip);
    value[WORK_FLOW] = G * value[SHEAR_POWER];
    value[CHIP_FLOW] = (1 - G) * value[SHEAR_POWER] + to_chip;
    value[HEAT_FLOW] = to_tool;
    value[HOLDER_FLOW] = to_holder;
    value[STORED] = C_c * (T_c - value[AMBIENT]) + C_b * (T_b - value[AMBIENT]);
    value[RATES] = (value[DISSIPATED_POWER] - to_chip - to_tool) / C_c;
    value[RATES + 1] = (to_tool - to_holder) / C_b;
}

const struct Part part = {
    .equations = "T_s = T_a + (1 - G) P_s/(rho c w h v),   G the share of Weiner 1955\n"
                 "C_c dT_c/dt = P_f - (T_c - T_s)/R_chip - (T_c - T_b)/R_c\n"
                 "C_b dT_b/dt = (T_c - T_b)/R_c - (T_b - T_a)/R_b",
    .variables = variables,
    .count = COUNT,
    .varies = 1,
    .evaluate = evaluate,
};
