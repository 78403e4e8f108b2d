within EvatSystems;
model GuidewayFriction "Friction between two flanges, from the imported FMU"
  extends Modelica.Mechanics.Translational.Interfaces.PartialTwoFlanges;
  replaceable EvatSystems.Interfaces.GuidewayFmu contact constrainedby EvatSystems.Interfaces.GuidewayFmu "Redeclare by the imported FMU";
  Modelica.Units.SI.Distance s_rel "position of flange_b relative to flange_a";
  Modelica.Units.SI.Velocity v_rel "velocity of flange_b relative to flange_a";
equation
  s_rel = flange_b.s - flange_a.s;
  v_rel = der(s_rel);
  contact.slip_velocity = v_rel;
  flange_b.f = contact.friction_force;
  flange_a.f = -contact.friction_force;
end GuidewayFriction;
