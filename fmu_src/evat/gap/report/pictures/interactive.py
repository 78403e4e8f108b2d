"""How is a picture drawn on the screen? With plotly, whose script stands once in the page; nothing is loaded from elsewhere."""

from __future__ import annotations

import html
import json
from typing import Any

import numpy as np
import numpy.typing as npt
import plotly.graph_objects as go
import plotly.io
from markupsafe import Markup
from plotly.offline import get_plotlyjs
from plotly.subplots import make_subplots

from evat.gap.report.pictures.chart import SKY, Chart, Line, Panel
from evat.html import PHONE_WIDTH
from evat.model import FloatArray

ROW = 340  # pixels
ABOVE, BELOW = 70, 90  # pixels, beside the panels
BETWEEN = 100  # pixels from panel to panel where they stand in one column: the title of an axis, and that of a panel
FLAT = 1e-3  # of its size: a column that changes by less is kept in full
DASHES, WIDTHS = {"dash": "dash", "dot": "dot"}, {"thick": 4.5}
CONFIG = {
    "displaylogo": False,
    "responsive": True,
    "plotlyServerURL": "",
    "modeBarButtons": [["zoom2d", "pan2d", "resetScale2d", "toImage"]],
}


def script() -> Markup:
    """The one script that all pictures need."""
    text: str = get_plotlyjs()
    return Markup("<script>{}</script>").format(Markup(text.replace("</script", "<\\/script")))


def drawn(chart: Chart) -> Markup:
    """The picture as a piece of HTML."""
    rows, columns = len(chart.panels), max(len(row) for row in chart.panels)
    titles = [_text(panel.title) for row in chart.panels for panel in row]
    figure = make_subplots(rows, columns, subplot_titles=titles, shared_xaxes="columns", vertical_spacing=0.13)
    choices, named = list[str](), set[tuple[str, str]]()
    for r, row in enumerate(chart.panels, 1):
        for c, panel in enumerate(row, 1):
            for line in panel.lines:
                visible = line.choice == "" or line.choice == chart.choices[0]
                figure.add_trace(_trace(line, visible, (line.name, line.choice) not in named), r, c)
                named.add((line.name, line.choice))
                choices.append(line.choice)
            _axes(figure, panel, r, c)
    figure.update_layout(
        template="plotly_white",
        height=ROW * rows + 60,
        margin={"l": 70, "r": 20, "t": ABOVE, "b": BELOW},
        legend={"orientation": "h", "y": 0, "yanchor": "bottom", "x": 0, "yref": "container"},
        hovermode="closest",
        barmode="overlay",
        font={"family": "system-ui, sans-serif", "size": 13},
    )
    if len(chart.choices) > 1:
        figure.update_layout(updatemenus=[_menu(chart, choices)])
    text = plotly.io.to_html(
        figure,
        config=CONFIG,
        include_plotlyjs=False,
        full_html=False,
        div_id=chart.key,
        default_height=f"{ROW * rows + 60}px",
        validate=False,
        post_script=_one_column(chart) if columns > 1 else None,
    )
    return Markup(text)


def _one_column(chart: Chart) -> str:
    """Where the page is narrow, as on a phone: the panels one below the other, column by column."""
    rows, columns = len(chart.panels), max(len(row) for row in chart.panels)
    count = rows * columns
    room = ROW * count - ABOVE - BELOW
    apart = BETWEEN / room
    tall = (1 - apart * (count - 1)) / count
    layout, titled = dict[str, object]({"height": ROW * count}), 0
    for row in range(rows):
        for column in range(len(chart.panels[row])):
            place = row * columns + column
            top = 1 - (column * rows + row) * (tall + apart)
            number = "" if place == 0 else str(place + 1)
            layout |= {f"xaxis{number}.domain": [0, 1], f"yaxis{number}.domain": [max(top - tall, 0.0), top]}
            if chart.panels[row][column].title:
                layout |= {f"annotations[{titled}].x": 0.5, f"annotations[{titled}].y": top}
                titled += 1
    taller = f"document.getElementById('{{plot_id}}').parentElement.style.height = '{ROW * count}px';"
    return f"if (matchMedia('(max-width: {PHONE_WIDTH}px)').matches) {{ {taller} Plotly.relayout('{{plot_id}}', {json.dumps(layout)}); }}"


def _text(text: str) -> str:
    """plotly reads its texts as markup."""
    return html.escape(text, quote=False)


def _trace(line: Line, visible: bool, first: bool) -> go.Scatter | go.Bar:
    about = {"name": _text(line.name), "legendgroup": _text(line.name), "showlegend": first, "visible": visible}
    x, y = _short(line.x), _short(line.y)
    if line.style == "bars":
        width = float(np.min(np.diff(x))) if x.size > 1 else None
        return go.Bar(x=x, y=y, width=width, marker={"color": line.colour}, **about)
    if line.style in ("dots", "marks"):
        errors = {} if line.sd is None else {"error_y": {"type": "data", "array": np.asarray(line.sd, dtype=np.float32)}}
        size, opacity = (3, 0.6) if line.style == "dots" else (9, 1.0)
        return go.Scatter(x=x, y=y, mode="markers", marker={"color": line.colour, "size": size, "opacity": opacity}, **errors, **about)
    return go.Scatter(
        x=x,
        y=y,
        mode="lines",
        line={"color": line.colour, "width": WIDTHS.get(line.style, 1.5), "dash": DASHES.get(line.style, "solid")},
        **about,
    )


def _short(column: FloatArray) -> npt.NDArray[np.floating[Any]]:
    """In half of the bytes where a screen cannot tell."""
    fine = np.ptp(column) < FLAT * np.max(np.abs(column), initial=0.0)
    shortened: npt.NDArray[np.floating[Any]] = column if fine else column.astype(np.float32)
    return shortened


def _axes(figure: go.Figure, panel: Panel, row: int, column: int) -> None:
    kind = "log" if panel.logarithmic else "linear"
    ticks = {"tickvals": list(range(len(panel.ticks))), "ticktext": [_text(tick) for tick in panel.ticks]} if panel.ticks else {}
    # Numbers below the axis keep clear of those beside it.
    apart = {"ticks": "outside", "ticklen": 7, "tickcolor": "rgba(0,0,0,0)"}
    figure.update_xaxes(title_text=_text(panel.x_label), type=kind, row=row, col=column, **apart, **ticks)
    figure.update_yaxes(title_text=_text(panel.y_label), type=kind, row=row, col=column)
    for low, high in panel.bands:
        figure.add_vrect(low, high, row=row, col=column, fillcolor=SKY, opacity=0.25, line_width=0, layer="below")


def _menu(chart: Chart, choices: list[str]) -> dict[str, object]:
    """What is shown where one of the choices is taken."""
    buttons = [
        {"label": _text(choice), "method": "restyle", "args": [{"visible": [own in ("", choice) for own in choices]}]}
        for choice in chart.choices
    ]
    return {"buttons": buttons, "x": 0, "xanchor": "left", "y": 1.0, "yanchor": "top", "pad": {"t": -68}, "active": 0}
