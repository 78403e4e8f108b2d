within EvatSystems.Interfaces;
partial block TurningFmu "Connectors of EvatTurning.fmu that the component uses"
  Modelica.Blocks.Interfaces.RealInput tool_displacement_x(unit = "m");
  Modelica.Blocks.Interfaces.RealInput tool_displacement_y(unit = "m");
  Modelica.Blocks.Interfaces.RealInput tool_velocity_x(unit = "m/s");
  Modelica.Blocks.Interfaces.RealInput tool_velocity_y(unit = "m/s");
  Modelica.Blocks.Interfaces.RealInput cutting_speed(unit = "m/s");
  Modelica.Blocks.Interfaces.RealInput contact_temperature(unit = "K");
  Modelica.Blocks.Interfaces.RealOutput tool_force_x(unit = "N");
  Modelica.Blocks.Interfaces.RealOutput tool_force_y(unit = "N");
  Modelica.Blocks.Interfaces.RealOutput principal_force(unit = "N");
  Modelica.Blocks.Interfaces.RealOutput dissipated_power(unit = "W");
end TurningFmu;
