!> --list: prints the elements, material laws, contact laws or solution commands, from the tables
!! with which a deck is read.
module program_list
  use command_table, only: load_commands
  use command_type, only: command_row_t
  use contact_table, only: load_contact_laws
  use contact_type, only: contact_law_t
  use element_table, only: load_elements
  use element_type, only: element_t
  use material_table, only: load_materials
  use material_type, only: material_t
  use word_contact_law, only: law_usage
  implicit none
  private
  public :: print_list

contains

  !> Print one list: elements, materials, contacts or commands; '' means all of them.
  subroutine print_list(name)
    character(*), intent(in) :: name
    type(element_t), allocatable :: element(:)
    type(material_t), allocatable :: material(:)
    type(contact_law_t), allocatable :: contact(:)
    type(command_row_t), allocatable :: command(:)
    integer :: i

    if (name == 'elements' .or. name == '') then
      call load_elements(element)
      print '(a)', 'elements'
      do i = 1, size(element)
        print '(2x,a,2x,a)', element(i)%name, trim(element(i)%source)
      end do
    end if
    if (name == 'materials' .or. name == '') then
      call load_materials(material)
      print '(a)', 'materials'
      do i = 1, size(material)
        print '(2x,a,2x,a)', material(i)%name, trim(material(i)%source)
      end do
    end if
    if (name == 'contacts' .or. name == '') then
      call load_contact_laws(contact)
      print '(a)', 'contacts'
      do i = 1, size(contact)
        print '(2x,a,2x,a)', contact(i)%name, trim(contact(i)%source)
        print '(20x,a)', law_usage(contact(i))
      end do
    end if
    if (name == 'commands' .or. name == '') then
      call load_commands(command)
      print '(a)', 'commands'
      do i = 1, size(command)
        print '(2x,a,2x,a)', command(i)%word, trim(command(i)%usage)
      end do
    end if
  end subroutine print_list

end module program_list
