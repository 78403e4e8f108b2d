within EvatSystems;
package Examples "Systems to simulate once the FMU is imported"
end Examples;
