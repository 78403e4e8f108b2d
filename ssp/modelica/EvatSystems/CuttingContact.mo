within EvatSystems;
model CuttingContact "Chip and tool between two flanges of the tool, the spindle and a heat port, from the imported FMU"
  replaceable EvatSystems.Interfaces.TurningFmu contact constrainedby EvatSystems.Interfaces.TurningFmu "Redeclare by the imported FMU";
  parameter Modelica.Units.SI.Length workpiece_radius = 0.02 "Radius at which the tool cuts";
  Modelica.Mechanics.Translational.Interfaces.Flange_a tool_x "Tool along the cutting direction";
  Modelica.Mechanics.Translational.Interfaces.Flange_a tool_y "Tool away from the machined surface";
  Modelica.Mechanics.Rotational.Interfaces.Flange_a spindle "Spindle that carries the work";
  Modelica.Thermal.HeatTransfer.Interfaces.HeatPort_a heat "Contact: its temperature is the proxy, what friction dissipates flows out here";
equation
  contact.tool_displacement_x = tool_x.s;
  contact.tool_displacement_y = tool_y.s;
  contact.tool_velocity_x = der(tool_x.s);
  contact.tool_velocity_y = der(tool_y.s);
  contact.cutting_speed = der(spindle.phi) * workpiece_radius;
  contact.contact_temperature = heat.T;
  tool_x.f = -contact.tool_force_x;
  tool_y.f = -contact.tool_force_y;
  spindle.tau = contact.principal_force * workpiece_radius;
  heat.Q_flow = -contact.dissipated_power;
end CuttingContact;
