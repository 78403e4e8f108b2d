within ;
package Bench "The components of EvatSystems with blocks in the place of imported FMUs, whose motion is known"
  block Viscous "Friction of 0.5 N.s/m"
    extends EvatSystems.Interfaces.GuidewayFmu;
  equation
    friction_force = 0.5 * slip_velocity;
  end Viscous;
  model StickSlip
    extends EvatSystems.Examples.StickSlip(redeclare block Contact = Bench.Viscous);
  end StickSlip;
  block Cut "A tool in a viscous and a springy cut"
    extends EvatSystems.Interfaces.TurningFmu;
  equation
    tool_force_x = -3 * tool_velocity_x;
    tool_force_y = -400 * tool_displacement_y;
    principal_force = 10 * cutting_speed + 2 * (contact_temperature - 300);
    dissipated_power = principal_force * cutting_speed;
  end Cut;
  model Spindle "Turns at 20 rad/s, whatever the torque"
    Modelica.Mechanics.Rotational.Interfaces.Flange_a flange;
    Real turned(start = 0, fixed = true);
  equation
    der(turned) = 20;
    flange.phi = turned;
  end Spindle;
  model Tool "At 350 K, whatever the heat"
    Modelica.Thermal.HeatTransfer.Interfaces.HeatPort_a port;
  equation
    port.T = 350;
  end Tool;
  model Turning
    EvatSystems.CuttingContact cutting(redeclare Bench.Cut contact, workpiece_radius = 0.1);
    Modelica.Mechanics.Translational.Components.Mass along(m = 1, s(fixed = true, start = 0), v(fixed = true, start = 1));
    Modelica.Mechanics.Translational.Components.Mass across(m = 1, s(fixed = true, start = 0.01), v(fixed = true, start = 0));
    Spindle spindle;
    Tool tool;
  equation
    connect(cutting.tool_x, along.flange_a);
    connect(cutting.tool_y, across.flange_a);
    connect(cutting.spindle, spindle.flange);
    connect(cutting.heat, tool.port);
  end Turning;
end Bench;
